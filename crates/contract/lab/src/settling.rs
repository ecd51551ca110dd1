// SPDX-License-Identifier: MIT OR Apache-2.0
//! The command that would decide what a run leaves open.

use terrafill_results::RunEnvironment;

/// Options that the command has in another form, or that say nothing of what is measured.
const NOT_REPEATED: [&str; 8] = [
    "studies",
    "depth",
    "processes",
    "seed",
    "size",
    "scenes",
    "techniques",
    "shard",
];

/// What to type to measure the same cases with so many processes.
///
/// - `study`: alone, as others would only take time
/// - `scene`: alone; empty for all scenes of the run
#[must_use]
pub fn bench_command(
    environment: &RunEnvironment,
    study: &str,
    scene: &str,
    processes: usize,
) -> String {
    let options = environment.options.iter();
    let options: Vec<(&str, &str)> = options.filter_map(|line| line.split_once('=')).collect();
    let values_of = |wanted: &str| {
        let found = options.iter().find(|(key, _)| *key == wanted);
        let values = found.map_or("", |(_, value)| *value).split('+');
        values.filter(|value| !value.is_empty())
    };
    let mut words = vec!["terrafill bench".to_owned()];
    match scene {
        "" => words.extend(values_of("scenes").map(str::to_owned)),
        scene => words.push(scene.to_owned()),
    }
    words.push(format!("--study {study}"));
    words.extend(values_of("techniques").map(|name| format!("--technique {name}")));
    let depths = values_of("depth").filter(|depth| *depth != "main");
    words.extend(depths.map(|depth| format!("--{depth}")));
    words.extend(values_of("size").map(|size| format!("--size {size}")));
    let own = options
        .iter()
        .filter(|(key, _)| !NOT_REPEATED.contains(key) && !key.contains('-'));
    words.extend(own.flat_map(|(key, values)| {
        let values = values.split('+');
        values.map(move |value| format!("--{key} {value}"))
    }));
    words.push(format!("--processes {processes}"));
    words.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_command_measures_the_same_cases_and_more_often() {
        let of = |options: &[&str]| RunEnvironment {
            options: options.iter().map(|line| (*line).to_owned()).collect(),
            ..RunEnvironment::default()
        };
        let quick = of(&[
            "studies=filling+globes",
            "depth=quick",
            "processes=1",
            "seed=1",
            "size=512x256",
            "scenes=hills+planet-134",
            "techniques=vertex+native",
            "ladder=planet-134",
            "shard=1/3",
        ]);
        assert_eq!(
            bench_command(&quick, "filling", "", 5),
            "terrafill bench hills planet-134 --study filling --technique vertex --technique native \
             --quick --size 512x256 --ladder planet-134 --processes 5"
        );
        assert_eq!(
            bench_command(&quick, "globes", "hills", 9),
            "terrafill bench hills --study globes --technique vertex --technique native --quick --size \
             512x256 --ladder planet-134 --processes 9"
        );
        // Control: a run of the default depth names none, and one without options is the default.
        assert_eq!(
            bench_command(&of(&["depth=main"]), "balls", "", 7),
            "terrafill bench --study balls --processes 7"
        );
    }
}
