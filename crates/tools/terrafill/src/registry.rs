// SPDX-License-Identifier: MIT OR Apache-2.0
//! The techniques, surfaces and studies there are. Adding one takes a crate and a line here.

use std::sync::OnceLock;
use terrafill_cesium::CesiumTechnique;
use terrafill_compute::ComputeTechnique;
use terrafill_contract::Technique;
use terrafill_filling::{ExtremeStudy, FillingStudy};
use terrafill_flight::FlightStudy;
use terrafill_growth::GrowthStudy;
use terrafill_instanced::InstancedTechnique;
use terrafill_moving::MovingStudy;
use terrafill_native::NativeTechnique;
use terrafill_overlays::{DRAPED_MESH, FLAT_MESH, MASK_TEXTURE};
use terrafill_precision::PrecisionStudy;
use terrafill_readback::ReadbackStudy;
use terrafill_results::{Chapter, Metric, Primary, RunPlan};
use terrafill_study::Study;
use terrafill_surface::{EllipsoidKind, SurfaceKind};
use terrafill_vertex::VertexTechnique;

/// Verb by which this program measures itself in a fresh process.
pub(crate) const GROWTH_SAMPLE: &str = "growth-sample";

/// Every technique, in the order in which they are measured. The first is the one whose pictures the
/// others' are laid beside.
pub(crate) static TECHNIQUES: &[&dyn Technique] = &[
    &VertexTechnique,
    &ComputeTechnique,
    &InstancedTechnique,
    &NativeTechnique,
    &FLAT_MESH,
    &DRAPED_MESH,
    &MASK_TEXTURE,
    &terrafill_edge_scan::EdgeScanTechnique,
];

/// Surfaces that scenes can name.
pub(crate) static SURFACES: &[&dyn SurfaceKind] = &[
    &EllipsoidKind,
    &terrafill_grid::GridKind,
    &terrafill_tiles::TilesKind,
    &terrafill_screen_grid::ScreenGridKind,
    &terrafill_spiral::SpiralKind,
];

/// What a user would pick instead of these techniques: measured beside them where this machine has it.
pub(crate) static RIVALS: &[&dyn Technique] = &[&CesiumTechnique];

/// Every study, in the order in which they are measured and reported.
pub(crate) static STUDIES: &[&dyn Study] = &[
    &FillingStudy {
        techniques: TECHNIQUES,
        rivals: RIVALS,
        surfaces: SURFACES,
    },
    &PrecisionStudy,
    &GrowthStudy {
        verb: Some(GROWTH_SAMPLE),
    },
    &ReadbackStudy,
    &FlightStudy {
        techniques: TECHNIQUES,
        surfaces: SURFACES,
    },
    &MovingStudy {
        techniques: TECHNIQUES,
        surfaces: SURFACES,
    },
    &terrafill_globes::GlobesStudy { surfaces: SURFACES },
    &terrafill_decals::DecalsStudy,
    &terrafill_paging::PagingStudy,
    &terrafill_shadows::ShadowsStudy,
    &terrafill_balls::BallsStudy,
    &terrafill_pipelines::PipelinesStudy,
    &ExtremeStudy {
        techniques: TECHNIQUES,
        surfaces: SURFACES,
    },
];

/// Chapters of all studies.
pub(crate) fn chapters() -> Vec<&'static dyn Chapter> {
    STUDIES.iter().map(|study| study.chapter()).collect()
}

/// Everything that any study measures.
pub(crate) fn metrics() -> &'static [Metric] {
    static METRICS: OnceLock<Vec<Metric>> = OnceLock::new();
    METRICS.get_or_init(|| {
        STUDIES
            .iter()
            .flat_map(|study| study.metrics())
            .copied()
            .collect()
    })
}

/// The same, of which only those of planned studies are marked as ranking: a suite measures metrics of
/// another study and is ranked by none.
pub(crate) fn metrics_of(plan: &RunPlan) -> Vec<Metric> {
    let marked = STUDIES.iter().flat_map(|study| {
        let is_planned = plan.cases.iter().any(|case| case.id.study == study.name());
        let metrics = study.metrics().iter();
        metrics.map(move |metric| {
            if is_planned {
                *metric
            } else {
                metric.ranking(Primary::No)
            }
        })
    });
    marked.collect()
}

/// The technique called `name`.
pub(crate) fn technique(name: &str) -> Option<&'static dyn Technique> {
    let mut all = TECHNIQUES.iter().copied();
    all.find(|technique| technique.name() == name)
}

/// Names of all of them.
pub(crate) fn names() -> Vec<&'static str> {
    TECHNIQUES
        .iter()
        .map(|technique| technique.name())
        .collect()
}

#[cfg(test)]
mod tests {
    //! What every technique promises, whichever it is.

    use super::*;
    use std::collections::BTreeSet;
    use terrafill_contract::{PlannedStep, Role, layouts};
    use terrafill_results::made_up::{MadeUpCase, MadeUpRun};
    use terrafill_results::{Block, Clock, Finding, Kind, Metric, Scope, Standing, Status};
    use terrafill_scene::{Overlap, Scene};
    use terrafill_stencil::matrix_row;
    use terrafill_study::{Depth, Request, RunOptions};
    use terrafill_variant::{Switches, Values};

    const OVERLAPS: [Overlap; 2] = [Overlap::Disjoint, Overlap::Ordered];

    #[test]
    fn every_metric_is_declared_once_and_has_a_meaning() {
        let names: BTreeSet<&str> = metrics().iter().map(|metric| metric.name).collect();
        assert_eq!(names.len(), metrics().len());
        assert!(metrics().iter().all(|metric| metric.meaning.ends_with('.')));
        let studies: BTreeSet<&str> = STUDIES.iter().map(|study| study.name()).collect();
        assert_eq!(studies.len(), STUDIES.len());
        for study in STUDIES {
            assert_eq!(study.chapter().study(), study.name());
        }
    }

    /// Studies that a file of claims names and nobody has: their claims would be in no report.
    fn unknown_studies(claims: &str) -> Vec<String> {
        let claims: toml::Table = claims.parse().expect("TOML");
        let claims = claims["claim"].as_array().expect("claims");
        let named = claims
            .iter()
            .filter_map(|claim| claim.get("study")?.as_str());
        let is_known = |name: &&str| STUDIES.iter().any(|study| study.name() == *name);
        named
            .filter(|name| !is_known(name))
            .map(str::to_owned)
            .collect()
    }

    #[test]
    fn every_claim_is_of_a_study_that_there_is() {
        let papers = std::fs::read_dir("../../../papers").expect("a folder");
        let mut files = 0;
        for file in papers {
            let path = file.expect("a file").path();
            let text = std::fs::read_to_string(&path).expect("readable");
            assert_eq!(unknown_studies(&text), [""; 0], "{}", path.display());
            files += 1;
        }
        assert!(files > 0);
        // Negative control.
        let misspelt = "[[claim]]\nstudy = 'pipeline'\n[[claim]]\nstudy = 'balls'\n";
        assert_eq!(unknown_studies(misspelt), ["pipeline"]);
    }

    #[test]
    fn every_time_says_what_it_covers_and_no_other_figure_does() {
        let lacking = |metrics: &[Metric]| -> Vec<&'static str> {
            let lacking = metrics
                .iter()
                .filter(|metric| !metric.has_scope_of_its_kind());
            lacking.map(|metric| metric.name).collect()
        };
        assert_eq!(lacking(metrics()), Vec::<&str>::new());
        // Negative controls: a time without a scope, and bytes with one.
        let time = Metric::less("time_ms", "ms", Kind::Time, "Time.");
        let bytes = Metric::less("held_bytes", "bytes", Kind::Bytes, "Bytes.");
        let faulty = [time, bytes.covering(Scope::DRAW)];
        assert_eq!(lacking(&faulty), ["time_ms", "held_bytes"]);
        assert!(lacking(&[time.covering(Scope::DRAW), bytes]).is_empty());
        // A comparison of a device's work refuses process CPU time by that word of a name.
        let times = metrics().iter().filter(|metric| metric.kind == Kind::Time);
        let unnamed = times.filter(|metric| metric.timer().is_none());
        let unnamed: Vec<&str> = unnamed.map(|metric| metric.name).collect();
        assert_eq!(unnamed, ["readback_rate", "suite_case_s"]);
    }

    /// A run in which every timed case of a study's plan is right, and every time is as long. Two processes:
    /// intervals take long and refuse nothing.
    fn made_of_plan(study: &dyn Study, depth: Depth) -> MadeUpRun {
        let request = Request {
            size: [64; 2],
            depth,
            ..Request::default()
        };
        let mut run = MadeUpRun {
            metrics: metrics().to_vec(),
            ..MadeUpRun::default()
        };
        let planned = study.plan(&request).expect("a plan");
        let cases = planned.groups.iter().flat_map(|group| group.cases());
        for case in cases.filter(|case| case.samples > 0) {
            let made = run.case(case.id.clone());
            let times = study.metrics().iter();
            for metric in times.filter(|metric| metric.kind == Kind::Time) {
                made.timed(metric, &[1.0; 2]);
            }
        }
        run
    }

    /// What a chapter says of its first comparison that was refused.
    fn refused(study: &dyn Study, run: &MadeUpRun) -> Option<String> {
        let run = run.loaded();
        let blocks = study.chapter().blocks(&run).expect("a chapter");
        let page = format!("{blocks:?}");
        let (_, said) = page.split_once(terrafill_lab::REFUSED)?;
        Some(said.chars().take(1_000).collect())
    }

    #[test]
    fn a_copy_of_a_scene_under_another_name_has_the_same_cases() {
        let folder = tempfile::tempdir().expect("a folder");
        // Scenes whose data is not here have no cases under either name.
        let keys = |scene: &str, name: &str, depth| {
            let request = Request {
                scenes: vec![scene.to_owned()],
                size: [64; 2],
                depth,
                ..Request::default()
            };
            let planned = STUDIES[0].plan(&request).expect("a plan");
            let cases = planned.groups.iter().flat_map(|group| group.cases());
            let keys = cases.map(|case| case.id.key().replacen(name, "scene", 1));
            keys.collect::<Vec<_>>()
        };
        for name in terrafill_scene::shipped_scene_names() {
            let text = terrafill_scene::shipped_scene_text(name).expect("it ships");
            let path = folder.path().join("copy.toml");
            let copy = text.replacen(&format!("name = \"{name}\""), "name = \"copy\"", 1);
            assert_ne!(copy, text);
            std::fs::write(&path, copy).expect("written");
            for depth in [Depth::Quick, Depth::Main] {
                let copied = keys(&path.display().to_string(), "copy", depth);
                assert_eq!(keys(name, name, depth), copied, "{name}");
            }
        }
        // Negative control: another scene has other cases.
        let of = |name: &str| keys(name, name, Depth::Quick);
        assert_ne!(of("california"), of("hills"));
    }

    #[test]
    fn no_comparison_of_any_chapter_is_refused() {
        for study in STUDIES {
            assert_eq!(
                refused(*study, &made_of_plan(*study, Depth::Full)),
                None,
                "{}",
                study.name()
            );
        }
        // Negative control: a fill of the ablation's that differs in one thing more.
        let mut studies = STUDIES.iter();
        let filling = studies
            .find(|study| study.name() == "filling")
            .expect("it is one");
        let mut run = made_of_plan(*filling, Depth::Full);
        let of = |case: &MadeUpCase, key: &str| case.id.condition_named(key).to_owned();
        run.cases.retain(|case| !of(case, "step").is_empty());
        let is_step = |case: &&mut MadeUpCase| of(case, "step") == "strips";
        for case in run.cases.iter_mut().filter(is_step) {
            let conditions = &mut case.id.conditions;
            conditions.insert("depth-rule".to_owned(), "another".to_owned());
        }
        let said = refused(*filling, &run).expect("two changes");
        assert!(said.contains("depth-rule"), "{said}");
    }

    /// Findings of a study's chapter, and of what it gives to the report's first page, that were not measured, and of
    /// them those that name no command.
    fn unmeasured(study: &dyn Study, run: &MadeUpRun) -> [Vec<Finding>; 2] {
        let run = run.loaded();
        let blocks = study.chapter().blocks(&run).expect("a chapter");
        let own = blocks.into_iter().filter_map(|block| match block {
            Block::Finding(finding) => Some(finding),
            _ => None,
        });
        let answers = study.chapter().answers(&run).expect("answers");
        let all = own.chain(answers.requirements);
        let open = all.filter(|finding| finding.standing == Standing::NotMeasured);
        let open: Vec<Finding> = open.collect();
        let mut silent = open.clone();
        silent.retain(|finding| !finding.because.contains("terrafill bench"));
        [open, silent]
    }

    #[test]
    fn what_was_not_measured_names_the_command_that_measures_it() {
        let mut found = 0;
        for study in STUDIES {
            let mut run = made_of_plan(*study, Depth::Quick);
            for case in &mut run.cases {
                case.figures.clear();
                case.ended(Status::Skipped, "no such device");
            }
            let [open, silent] = unmeasured(*study, &run);
            found += open.len();
            assert_eq!(silent, [], "{}", study.name());
        }
        // Control: there are such findings.
        assert!(found > 10, "{found}");
    }

    #[test]
    fn every_study_declares_the_conditions_that_it_plans() {
        let request = Request {
            size: [64; 2],
            depth: Depth::Quick,
            ..Request::default()
        };
        let options = RunOptions {
            processes: 1,
            process: 0,
            warm_up: 0,
            seed: 1,
            shard: None,
        };
        // The runner refuses others; its own tests have the control.
        for study in STUDIES {
            let planned = terrafill_study::plan(&[*study], &request, &options);
            assert!(planned.is_ok(), "{}: {:?}", study.name(), planned.err());
        }
    }

    #[test]
    fn metrics_are_marked_that_chapters_rank_by() {
        for study in STUDIES {
            for clock in [Clock::Gpu, Clock::ProcessCpu] {
                let marked = study.metrics().iter();
                let marked = marked.filter(|metric| metric.primary.ranks(clock));
                let marked: Vec<&str> = marked.map(|metric| metric.name).collect();
                let ranking = study.chapter().primary_metric(clock);
                assert_eq!(marked, ranking.into_iter().collect::<Vec<_>>());
            }
        }
        // Control: a metric of one clock ranks by no other, and one without a mark by none.
        assert!(!Primary::Gpu.ranks(Clock::ProcessCpu) && !Primary::No.ranks(Clock::Gpu));
    }

    #[test]
    fn names_are_distinct_and_found() {
        let distinct: BTreeSet<&str> = names().into_iter().collect();
        assert_eq!(distinct.len(), TECHNIQUES.len());
        for name in names() {
            assert_eq!(technique(name).map(|found| found.name()), Some(name));
        }
        assert!(technique("reference").is_none());
    }

    #[test]
    fn main_variants_suit_the_scene_they_are_made_for() {
        for technique in TECHNIQUES {
            let ordered = technique.main(Overlap::Ordered);
            assert_eq!(technique.check(&ordered, Overlap::Ordered), Ok(()));
            // Negative control: numbers of regions that overlap would mix.
            let disjoint = technique.main(Overlap::Disjoint);
            assert_eq!(technique.check(&disjoint, Overlap::Disjoint), Ok(()));
            assert!(technique.check(&disjoint, Overlap::Ordered).is_err());
        }
    }

    #[test]
    fn every_value_that_a_technique_names_is_one_that_it_reads() {
        for technique in TECHNIQUES {
            let main = technique.main(Overlap::Disjoint);
            for parameter in technique.parameters() {
                let values = match parameter.values {
                    Values::OneOf(values) | Values::RouteOr(values) => values,
                    Values::Percent => &["1", "100"],
                    Values::Pixels => &["0.5", "off"],
                };
                let defaults = std::iter::once(parameter.default);
                let defaults = defaults.chain(parameter.default_in.iter().map(|(_, value)| *value));
                for value in values.iter().copied().chain(defaults) {
                    let variant = main.clone().with(parameter.key, value);
                    // Some do not go together with the rest; none is unknown.
                    if let Err(error) = technique.check(&variant, Overlap::Disjoint) {
                        assert!(error.found.contains(" with "), "{error}");
                    }
                    assert_eq!(variant.value(parameter.key), Some(value));
                }
                assert!(
                    Switches::TABLE
                        .iter()
                        .all(|switch| switch.key != parameter.key)
                );
            }
            assert!(main.keys().len() > Switches::TABLE.len());
        }
    }

    #[test]
    fn variants_of_every_role_are_right_for_their_scene() {
        for name in ["california", "square-10m", "planet-134"] {
            let scene = Scene::shipped(name, None).expect("needs no data");
            for technique in TECHNIQUES {
                for role in [Role::Main, Role::Quick, Role::Layouts, Role::Sweep] {
                    let variants = technique.variants(&scene, role);
                    for variant in &variants {
                        let checked = technique.check(variant, scene.overlap);
                        assert_eq!(checked, Ok(()), "{}", variant.name());
                        assert_eq!(variant.technique(), technique.name());
                    }
                    let names: BTreeSet<String> = variants.iter().map(|v| v.name()).collect();
                    assert_eq!(names.len(), variants.len(), "{role:?}");
                    let may_be_none = role == Role::Sweep
                        || role == Role::Layouts && !technique.has_stencil_switches();
                    assert!(may_be_none || !variants.is_empty(), "{role:?}");
                }
            }
        }
    }

    /// Techniques with an ablation and a matrix.
    fn by_stencil() -> impl Iterator<Item = &'static &'static dyn Technique> {
        let all = TECHNIQUES.iter();
        all.filter(|technique| technique.has_stencil_switches())
    }

    #[test]
    fn without_a_stencil_there_is_no_ablation_and_every_variant_is_approximate() {
        let mut without = 0;
        for technique in TECHNIQUES.iter().filter(|t| !t.has_stencil_switches()) {
            without += 1;
            for overlap in OVERLAPS {
                let main = technique.main(overlap);
                assert!(technique.ablation(overlap).is_empty());
                assert!(technique.is_approximate(&main));
                assert_eq!(matrix_row(*technique, &main, overlap).len(), 5);
            }
        }
        // Negative controls: there are techniques of both kinds, and volumes have to be right.
        assert!(without > 0 && without < TECHNIQUES.len(), "{without}");
        let volumes = |t: &&dyn Technique| t.is_approximate(&t.main(Overlap::Disjoint));
        assert!(!by_stencil().any(volumes));
    }

    #[test]
    fn no_cell_of_a_matrix_stands_twice_and_all_are_right() {
        for overlap in OVERLAPS {
            for technique in by_stencil() {
                for base in layouts(*technique, overlap) {
                    let row = matrix_row(*technique, &base, overlap);
                    let names: BTreeSet<String> = row.iter().map(|v| v.name()).collect();
                    assert_eq!(names.len(), row.len());
                    assert!(row.len() >= 14, "{}: {}", base.name(), row.len());
                    assert_eq!(row[0], base);
                    for variant in row {
                        assert_eq!(technique.check(&variant, overlap), Ok(()));
                    }
                }
            }
        }
    }

    /// Parts of the name that one step has and the other has not.
    fn differences(a: &PlannedStep, b: &PlannedStep) -> usize {
        let parts = |step: &PlannedStep| -> BTreeSet<String> {
            step.variant.name().split(',').map(str::to_owned).collect()
        };
        parts(a).symmetric_difference(&parts(b)).count()
    }

    #[test]
    fn every_step_changes_one_thing() {
        for technique in by_stencil() {
            for overlap in OVERLAPS {
                let steps = technique.ablation(overlap);
                let backend = technique.name();
                assert!(steps.len() > 10, "{backend}: {}", steps.len());
                let names: BTreeSet<String> =
                    steps.iter().map(|step| step.variant.name()).collect();
                assert_eq!(
                    names.len(),
                    steps.len(),
                    "{backend}: two steps are the same"
                );
                for step in &steps {
                    assert_eq!(
                        technique.check(&step.variant, overlap),
                        Ok(()),
                        "{}",
                        step.name
                    );
                }
                let mut before = &steps[0];
                for step in &steps[1..] {
                    // A value that becomes another one is two parts. Walls of single triangles are
                    // always lists, and two edges in a triangle are never strips. Which faces are drawn
                    // as covers has no meaning where none are. Without its bottom cap a volume can be
                    // counted in front of the surface only. Four: single triangles have no
                    // vertex size either.
                    let allowed = match step.name {
                        "one-volume" => 4,
                        "two-edges" | "screen-cover" | "z-pass" => 3,
                        _ => 2,
                    };
                    let found = differences(before, step);
                    assert!(
                        (1..=allowed).contains(&found),
                        "{backend}, {}: {} → {}",
                        step.name,
                        before.variant.name(),
                        step.variant.name()
                    );
                    if !step.is_aside {
                        before = step;
                    }
                }
                // Negative control: steps that lie far apart differ in more than one switch.
                let far = differences(&steps[0], &steps[steps.len() - 1]);
                assert!(far > 3, "{backend}: {far}");
            }
        }
    }
}
