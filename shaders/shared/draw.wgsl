// Arguments of indexed indirect draws, two a region: the whole volume, and the volume without its
// bottom cap.
struct DrawArguments {
    index_count: atomic<u32>,
    instance_count: u32,
    first_index: atomic<u32>,
    base_vertex: i32,
    first_instance: u32,
};

@group(3) @binding(0) var<storage, read_write> draws: array<DrawArguments>;
