// SPDX-License-Identifier: MIT OR Apache-2.0
//! Position routes and charts on the device: their printed text as a compute shader, against the
//! exact offsets and angles, the bounds and the emulation.

use terrafill_core::{Ellipsoid, Geodetic};
use terrafill_gpu::{Gpu, GpuOptions, open_for_test, read_buffer};
use terrafill_texture::{
    Arithmetic, Chart, CoordinateRoute, DepthFormat, DepthMapping, DepthStorage, MapExtent,
    MapRegion, PositionRoute, Program, Sample, View,
};

/// Invocations of a workgroup: whatever every device can do.
const WORKGROUP: u32 = 64;

/// A module that computes `call` for every input `p`.
fn module_text(function: &str, constants_type: &str, call: &str) -> String {
    format!(
        "@group(0) @binding(0) var<uniform> constants: {constants_type};\n\
         @group(0) @binding(1) var<storage, read> inputs: array<vec4f>;\n\
         @group(0) @binding(2) var<storage, read_write> results: array<vec4f>;\n\
         {function}\n\
         @compute @workgroup_size({WORKGROUP})\n\
         fn main(@builtin(global_invocation_id) id: vec3u) {{\n    \
         if id.x < arrayLength(&inputs) {{\n        \
         let p = inputs[id.x];\n        results[id.x] = {call};\n    }}\n}}\n"
    )
}

fn position_text(route: PositionRoute, depth: &DepthFormat) -> String {
    let call = "vec4f(fragment_offset(p.xy, p.z, constants), 0.0)";
    module_text(&route.wgsl(depth), "PositionConstants", call)
}

fn chart_text(route: &CoordinateRoute) -> String {
    let call = "vec4f(route_angles(p.xyz, constants), 0.0, 0.0)";
    module_text(&route.wgsl(), "RouteConstants", call)
}

fn filled(gpu: &Gpu, usage: wgpu::BufferUsages, bytes: &[u8]) -> wgpu::Buffer {
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("texture"),
        size: bytes.len() as u64,
        usage: usage | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    gpu.queue.write_buffer(&buffer, 0, bytes);
    buffer
}

/// What the device makes of `text` for these inputs.
fn run(gpu: &Gpu, text: &str, constants: &[[f32; 4]], inputs: &[[f32; 3]]) -> Vec<[f32; 4]> {
    let uniform = wgpu::BufferUsages::UNIFORM;
    let constants = filled(gpu, uniform, bytemuck::cast_slice(constants));
    let padded: Vec<[f32; 4]> = inputs.iter().map(|d| [d[0], d[1], d[2], 0.0]).collect();
    let storage = wgpu::BufferUsages::STORAGE;
    let input = filled(gpu, storage, bytemuck::cast_slice(&padded));
    // NaN, so that a result that is never written shows.
    let nothing = vec![[f32::NAN; 4]; inputs.len()];
    let readable = storage | wgpu::BufferUsages::COPY_SRC;
    let output = filled(gpu, readable, bytemuck::cast_slice(&nothing));
    let module = gpu
        .device
        .create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("texture"),
            source: wgpu::ShaderSource::Wgsl(text.into()),
        });
    let pipeline = gpu
        .device
        .create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("texture"),
            layout: None,
            module: &module,
            entry_point: Some("main"),
            compilation_options: Default::default(),
            cache: None,
        });
    let entries: Vec<_> = [&constants, &input, &output]
        .into_iter()
        .zip(0..)
        .map(|(buffer, binding)| wgpu::BindGroupEntry {
            binding,
            resource: buffer.as_entire_binding(),
        })
        .collect();
    let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("texture"),
        layout: &pipeline.get_bind_group_layout(0),
        entries: &entries,
    });
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        let count = u32::try_from(inputs.len()).expect("some thousands");
        pass.dispatch_workgroups(count.div_ceil(WORKGROUP), 1, 1);
    }
    gpu.queue.submit([encoder.finish()]);
    let bytes = read_buffer(gpu, &output).expect("readable");
    bytemuck::cast_slice::<u8, f32>(&bytes)
        .chunks_exact(4)
        .map(|four| [four[0], four[1], four[2], four[3]])
        .collect()
}

/// How many results equal the emulation with `fma` rounded once or twice bit by bit.
fn equal_to_emulation(
    program: &Program,
    constants: &[[f32; 4]],
    inputs: &[[f32; 3]],
    results: &[[f32; 4]],
) -> usize {
    inputs
        .iter()
        .zip(results)
        .filter(|(input, result)| {
            [Arithmetic::Fused, Arithmetic::Separate]
                .into_iter()
                .map(|arithmetic| program.emulate_all(constants, **input, arithmetic))
                .any(|all| {
                    all.iter()
                        .zip(result.iter())
                        .all(|(a, b)| (a - b).abs() <= 0.0)
                })
        })
        .count()
}

/// A kilometre at 20° E, 45° N, seen aslant from `distance_m`; 60° over 1920 × 1080 pixels.
fn region_and_view(distance_m: f64, depth: DepthFormat) -> (MapRegion, View) {
    let extent = MapExtent::from_degrees(19.995, 44.995, 20.005, 45.005);
    let body = Ellipsoid::WGS84;
    let region = MapRegion::new(body, extent, (0.0, 0.0)).expect("a region");
    let target = body.geodetic_to_ecef(Geodetic::from_degrees(20.001, 45.002, 0.0));
    let up = body.geodetic_surface_normal(20_f64.to_radians(), 45_f64.to_radians());
    let east = glam::DVec3::Z.cross(up).normalize();
    let north = up.cross(east);
    let backward = (up * 0.8 - north * 0.5 + east * 0.33).normalize();
    let right = north.cross(backward).normalize();
    let focal_y = 1.0 / 30_f64.to_radians().tan();
    let view = View {
        eye_ecef: target + backward * distance_m,
        right,
        up: backward.cross(right),
        backward,
        focal_x: focal_y * 1080.0 / 1920.0,
        focal_y,
        size: [1920, 1080],
        depth,
    };
    (region, view)
}

/// Pixel centres all over the screen.
fn pixels() -> impl Iterator<Item = [f32; 2]> {
    (0..40_u16)
        .flat_map(|i| (0..40_u16).map(move |j| [f32::from(i * 49) + 0.5, f32::from(j * 27) + 0.5]))
}

#[test]
fn positions_on_the_device_are_within_their_bound() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let endless = f64::INFINITY;
    let formats = [
        (DepthMapping::Reversed, DepthStorage::Float32, endless),
        (DepthMapping::Reversed, DepthStorage::Float32, 1e8),
        (DepthMapping::Standard, DepthStorage::Float32, endless),
        (DepthMapping::Standard, DepthStorage::Unorm24, 1e8),
        (DepthMapping::Logarithmic, DepthStorage::Float32, 1e8),
    ];
    for (mapping, storage, far_m) in formats {
        for (near_m, distance_m) in [(0.1, 20.0), (1.0, 1e3), (1.0, 1e6)] {
            let format = DepthFormat::new(mapping, storage, near_m, far_m).expect("a format");
            let (region, view) = region_and_view(distance_m, format);
            let depth = format.stored(distance_m);
            let inputs: Vec<[f32; 3]> = pixels().map(|[x, y]| [x, y, depth]).collect();
            for route in PositionRoute::ALL {
                let constants = route.constants(&view, &region);
                let text = position_text(route, &format);
                let results = run(&gpu, &text, &constants, &inputs);
                let error = |result: &[f32; 4], input: &[f32; 3]| {
                    let pixel = [f64::from(input[0]), f64::from(input[1])];
                    let exact = view.exact_offset_m(&region, pixel, distance_m);
                    let [x, y, z, _] = result.map(f64::from);
                    (glam::DVec3::new(x, y, z) - exact).length()
                };
                let worst = results
                    .iter()
                    .zip(&inputs)
                    .map(|(result, input)| error(result, input))
                    .fold(0.0, f64::max);
                let residual = route.residual(&view, &region, distance_m);
                let program = route.program(&format);
                let equal = equal_to_emulation(&program, &constants, &inputs, &results);
                let case = format!("{} {} {distance_m} m", route.name(), format.name());
                eprintln!(
                    "{case}: device {worst:.3e} m, bound {:.3e}, emulation {:.3e}; {equal} of {} equal",
                    residual.max_m,
                    residual.measured_max_m,
                    inputs.len()
                );
                assert!(
                    worst.is_finite() && worst <= 1.02 * residual.max_m,
                    "{case}: {worst}"
                );
            }
        }
    }
}

#[test]
fn charts_on_the_device_are_within_their_residual() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let body = Ellipsoid::WGS84;
    let square = |latitude: f64, size: f64| {
        let half = 0.5 * size;
        let (south, north) = (latitude - half, latitude + half);
        let extent = MapExtent::from_degrees(180.0 - half, south, 180.0 + half, north);
        MapRegion::new(body, extent, (-11e3, 9e3)).expect("a region")
    };
    let cap = MapExtent::from_degrees(-180.0, 70.0, 180.0, 90.0);
    let cap = MapRegion::anchored(body, cap, (-11e3, 9e3)).expect("a region");
    for route in Chart::all().filter(|c| !matches!(c, Chart::Cube(_))) {
        let regions = match route {
            Chart::Azimuthal(_) => vec![cap],
            _ => vec![square(45.0, 0.01), square(-70.0, 2.0), square(0.0, 10.0)],
        };
        let route = CoordinateRoute::Chart(route);
        for region in regions {
            let samples: Vec<Sample> = region.samples(2000).collect();
            let inputs: Vec<[f32; 3]> = samples.iter().map(|s| s.offset_m).collect();
            let constants = route.constants(&region);
            let results = run(&gpu, &chart_text(&route), &constants, &inputs);
            let worst = worst_angle(&samples, &results);
            let residual = route.residual(&region);
            let equal = equal_to_emulation(&route.program(), &constants, &inputs, &results);
            let name = route.name();
            eprintln!(
                "{name}: device {worst:.3e} rad, residual {:.3e}; {equal} of {} equal",
                residual.max_rad,
                inputs.len()
            );
            assert!(
                worst <= 1.02 * residual.max_rad,
                "{name}: {worst} {residual:?}"
            );
        }
    }
}

/// Largest error of an angle, longitude the short way round and not on the axis.
fn worst_angle(samples: &[Sample], results: &[[f32; 4]]) -> f64 {
    let turn = std::f64::consts::TAU;
    let mut worst = 0.0_f64;
    for (sample, result) in samples.iter().zip(results) {
        let pairs = result.iter().zip(sample.angles_rad);
        for (got, exact) in pairs.skip(usize::from(sample.on_axis)) {
            let off = (f64::from(*got) - exact).abs();
            // A maximum would drop NaN.
            let off = if off.is_nan() { f64::INFINITY } else { off };
            worst = worst.max(off.min((turn - off).abs()));
        }
    }
    worst
}

#[test]
fn a_wrong_text_is_noticed_on_the_device() {
    let Some(gpu) = open_for_test(&GpuOptions::default()) else {
        return;
    };
    let extent = MapExtent::from_degrees(179.0, 44.0, 181.0, 46.0);
    let region = MapRegion::new(Ellipsoid::WGS84, extent, (0.0, 0.0)).expect("a region");
    let route = CoordinateRoute::parse("gnomonic-4").expect("a chart");
    let samples: Vec<Sample> = region.samples(200).collect();
    let inputs: Vec<[f32; 3]> = samples.iter().map(|s| s.offset_m).collect();
    let constants = route.constants(&region);
    let text = chart_text(&route);
    let bound = route.residual(&region).max_rad;
    let worst = |text: &str| worst_angle(&samples, &run(&gpu, text, &constants, &inputs));
    assert!(worst(&text) <= 1.02 * bound);
    for (from, to) in [
        ("constants.c1.x", "constants.c1.y"),
        ("constants.c2.x", "constants.c2.z"),
        ("d.y", "d.z"),
        ("p.xyz", "p.yxz"),
        ("results[id.x] =", "results[id.x / 2u] ="),
    ] {
        assert!(text.contains(from), "{from}");
        assert!(worst(&text.replace(from, to)) > 1.02 * bound, "{from}");
    }
}
