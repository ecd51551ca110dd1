// SPDX-License-Identifier: MIT OR Apache-2.0
//! The command that would decide what a run leaves open, or measure what it has not.

use terrafill_results::threshold::MIN_REPLICATES;
use terrafill_results::{Answers, Block, Finding, Run, RunEnvironment, Standing};

/// How every command begins.
const BENCH: &str = "terrafill bench";

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

/// What to type for a scene that a run was given: `terrain/everest`, or a scene file, of one that calls itself
/// `everest`.
#[must_use]
pub fn scene_argument<'a>(environment: &'a RunEnvironment, scene: &'a str) -> &'a str {
    let own_name = |given: &str| {
        let file = given.rsplit('/').next().unwrap_or(given);
        file.strip_suffix(".toml").unwrap_or(file) == scene
    };
    let options = environment.options.iter();
    let mut given = options
        .filter_map(|line| line.strip_prefix("scenes="))
        .flat_map(|scenes| scenes.split('+'));
    given.find(|given| own_name(given)).unwrap_or(scene)
}

/// What to type to measure the same cases with so many processes.
///
/// - `study`: alone, as others would only take time
/// - `scene`: alone; empty for all scenes of the run
#[must_use]
pub(crate) fn bench_command(
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
    let mut words = vec![BENCH.to_owned()];
    match scene {
        "" => words.extend(values_of("scenes").map(str::to_owned)),
        scene => words.push(scene_argument(environment, scene).to_owned()),
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

/// What to type to measure all that a study can: whatever a run of fewer cases has not measured is among it.
#[must_use]
pub fn full_command(environment: &RunEnvironment, study: &str) -> String {
    let sizes = environment.options.iter();
    let sizes = sizes.filter(|line| line.starts_with("size=")).cloned();
    let full = RunEnvironment {
        options: std::iter::once("depth=full".to_owned())
            .chain(sizes)
            .collect(),
        ..RunEnvironment::default()
    };
    bench_command(&full, study, "", MIN_REPLICATES)
}

/// Blocks of a study's chapter, in which every finding that was not measured names the command that measures it.
#[must_use]
pub fn with_commands(blocks: Vec<Block>, run: &Run, study: &str) -> Vec<Block> {
    let block = |block| match block {
        Block::Finding(finding) => Block::Finding(with_command(finding, run, study)),
        other => other,
    };
    blocks.into_iter().map(block).collect()
}

/// The same of what a chapter offers for the first page.
#[must_use]
pub fn answers_with_commands(answers: Answers, run: &Run, study: &str) -> Answers {
    let requirements = answers.requirements.into_iter();
    let requirements = requirements.map(|finding| with_command(finding, run, study));
    Answers {
        requirements: requirements.collect(),
        ..answers
    }
}

/// A finding with the command that measures it, where this run has not and the finding names none.
fn with_command(finding: Finding, run: &Run, study: &str) -> Finding {
    if finding.standing != Standing::NotMeasured || finding.because.contains(BENCH) {
        return finding;
    }
    let command = full_command(&run.environment, study);
    let because = match finding.because.trim_end_matches('.') {
        "" => format!("To measure it: {command}"),
        why => format!("{why}. To measure it: {command}"),
    };
    Finding { because, ..finding }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_results::made_up::MadeUpRun;

    #[test]
    fn a_finding_that_was_not_measured_names_the_command_that_measures_it_and_no_other_does() {
        let mut made = MadeUpRun::default();
        let options = ["depth=quick", "size=512x256", "scenes=hills"];
        made.environment.options = options.map(str::to_owned).to_vec();
        let run = made.loaded();
        let because = |standing, because: &str| {
            let finding = Finding {
                claim: "It grows".to_owned(),
                standing,
                because: because.to_owned(),
            };
            with_command(finding, &run, "balls").because
        };
        let command = "terrafill bench --study balls --full --size 512x256 --processes 5";
        assert_eq!(
            because(Standing::NotMeasured, ""),
            format!("To measure it: {command}")
        );
        assert_eq!(
            because(Standing::NotMeasured, "no device."),
            format!("no device. To measure it: {command}")
        );
        // Negative controls: what is decided needs none, and one command is enough.
        assert_eq!(because(Standing::Holds, "2 px"), "2 px");
        let own = "To settle it: terrafill bench --study balls --processes 5";
        assert_eq!(because(Standing::NotMeasured, own), own);
    }

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
            "ablation=planet-134",
            "shard=1/3",
        ]);
        assert_eq!(
            bench_command(&quick, "filling", "", 5),
            "terrafill bench hills planet-134 --study filling --technique vertex --technique native \
             --quick --size 512x256 --ablation planet-134 --processes 5"
        );
        assert_eq!(
            bench_command(&quick, "globes", "hills", 9),
            "terrafill bench hills --study globes --technique vertex --technique native --quick --size \
             512x256 --ablation planet-134 --processes 9"
        );
        let folders = of(&["scenes=hills+terrain/everest+out/scenes/own.toml"]);
        for (scene, given) in [
            ("everest", "terrain/everest"),
            ("own", "out/scenes/own.toml"),
            ("hills", "hills"),
            // Controls: of those that were given none, and a name that only ends alike.
            ("california", "california"),
            ("rest", "rest"),
        ] {
            let command = format!("terrafill bench {given} --study filling --processes 5");
            assert_eq!(bench_command(&folders, "filling", scene, 5), command);
        }
        // Control: a run of the default depth names none, and one without options is the default.
        assert_eq!(
            bench_command(&of(&["depth=main"]), "balls", "", 7),
            "terrafill bench --study balls --processes 7"
        );
    }
}
