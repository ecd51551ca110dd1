// SPDX-License-Identifier: MIT OR Apache-2.0
//! The sections on layers: the ladder of features, pictures, faults, projections, and triangles against pixels.

use super::rows::{cases, noise, value};
use super::{FAULTS, tessellation};
use crate::keys::{
    FAULT, GLOBE_NON_FINITE, GLOBE_SHADE_MAX, GLOBE_SHADE_P99, GLOBE_SHADE_POLAR_MAX,
    GLOBE_SHADE_POLAR_P99, PICTURES, PROJECTION, REMOVED, VIEW, WHAT,
};
use crate::published::TABLE_3;
use crate::table::{by_case, conditions};
use terrafill_plot::number::significant;
use terrafill_results::{
    Block, Case, Cell, ChapterError, Clock, ConditionKey, Estimate, Finding, Heading, Noise,
    Picture, PictureFigure, Pictures, Row, Run, Standing, Table, over_processes, process_medians,
};

/// What is measured.
const WHAT_IS_COMPARED: &str = "Colour with water, bumps, clouds and lights of night lie over the spiral, each in its own cube map or in a \
     picture by longitude and latitude, as dense along the equator. They are baked from smooth functions of \
     direction, and each pixel is held against these functions in f64, at the place that its ray meets: the \
     largest channel's difference, 1 being white. A frame makes the mesh, sends it and draws it.";

/// The sections; nothing where no case was planned.
pub(crate) fn blocks(run: &Run, clock: Clock) -> Result<Vec<Block>, ChapterError> {
    let ladder = cases(run, "ladder");
    if ladder.is_empty() {
        return Ok(Vec::new());
    }
    let mut blocks = vec![
        Block::section("Five layers"),
        Block::Text(WHAT_IS_COMPARED.to_owned()),
        Block::Table(ladder_table(&ladder, clock)),
        Block::Finding(bump_finding(&ladder, clock, noise(run, clock))),
        Block::Table(errors(
            "Cube maps against pictures by angles",
            &cases(run, "pictures"),
            PICTURES,
        )),
        Block::Finding(pole_finding(&cases(run, "pictures"))),
        Block::Table(errors(
            "Faults of the printed shader",
            &cases(run, "faults"),
            FAULT,
        )),
        Block::Finding(fault_finding(&cases(run, "faults"))),
    ];
    blocks.extend(tessellation::blocks(run, clock)?);
    let shown = ["ladder", "pictures", "faults", "projections"];
    let all: Vec<&Case> = shown.iter().flat_map(|what| cases(run, what)).collect();
    blocks.extend(pictures(&all));
    Ok(blocks)
}

fn ladder_table(cases: &[&Case], clock: Clock) -> Table {
    let metric = crate::clock::whole(clock);
    let drawing = crate::clock::draw(clock);
    let first = cases.first().and_then(|case| value(case, drawing));
    let mut before = first;
    let rows = cases
        .iter()
        .zip(TABLE_3)
        .map(|(case, (removed, published))| {
            let ms = value(case, drawing);
            let ratio = ms.zip(first).map(|(ms, first)| ms / first);
            let step = ms
                .zip(before)
                .zip(first)
                .map(|((ms, before), first)| (before - ms) / first);
            before = ms;
            let why = match case.reason.as_str() {
                "" => "not measured",
                reason => reason,
            };
            Row::new(vec![
                Cell::name(removed),
                Cell::plain(significant(published / TABLE_3[0].1)),
                Cell::or_absent(ratio.map(significant), why),
                Cell::or_absent(step.map(|step| format!("{:.1} %", 100.0 * step)), why),
                Cell::or_absent(ms.map(significant), why),
                Cell::or_absent(value(case, metric).map(significant), why),
                Cell::or_absent(value(case, GLOBE_SHADE_P99).map(significant), why),
            ])
        });
    Table {
        caption: "Features removed one after the other, each row lacking all above: ours beside Gebbie & Bailey's Table \
                  3, as ratios to the first row"
            .to_owned(),
        headings: vec![
            Heading::plain("feature removed"),
            Heading::plain("published, ratio"),
            Heading::plain("ours, ratio"),
            Heading::plain("saved of the whole"),
            Heading::metric("draw, ms", drawing),
            Heading::metric("frame, ms", metric),
            Heading::metric("off the functions, 99 %", GLOBE_SHADE_P99),
        ],
        rows: rows.collect(),
        ..Table::default()
    }
}

/// What each removal saves, ms, by its name.
fn savings(cases: &[&Case], clock: Clock) -> Option<Vec<(&'static str, f64)>> {
    let times: Option<Vec<f64>> = cases
        .iter()
        .map(|case| value(case, crate::clock::draw(clock)))
        .collect();
    let times = times.filter(|times| times.len() == TABLE_3.len())?;
    let pairs = times.windows(2).zip(&TABLE_3[1..]);
    Some(
        pairs
            .map(|(pair, (name, _))| (*name, pair[0] - pair[1]))
            .collect(),
    )
}

/// The removal that is said to save most.
const BUMPS: &str = "Bump mapping";

/// The whole frame with what removing bumps saves over the frame with what another removal saves, by process: so
/// that a difference of savings is measured by what identical frames differ by.
fn bumps_over(cases: &[&Case], other: &str, clock: Clock) -> Option<Estimate> {
    let times = cases
        .iter()
        .map(|case| process_medians(case, crate::clock::draw(clock)));
    let times: Vec<_> = times.collect();
    let saved = |name: &str, process: &u32| {
        let at = TABLE_3.iter().position(|(known, _)| *known == name)?;
        Some(times[at.checked_sub(1)?].get(process)? - times[at].get(process)?)
    };
    let ratios = times.first()?.iter().filter_map(|(process, whole)| {
        Some((whole + saved(BUMPS, process)?) / (whole + saved(other, process)?))
    });
    over_processes(&ratios.collect::<Vec<f64>>())
}

fn bump_finding(cases: &[&Case], clock: Clock, noise: Option<Noise>) -> Finding {
    let savings = savings(cases, clock).unwrap_or_default();
    let bumps = savings.iter().find(|(name, _)| *name == BUMPS);
    let others = savings.iter().filter(|(name, _)| *name != BUMPS);
    let most = others.max_by(|a, b| a.1.total_cmp(&b.1));
    let over = most.and_then(|(other, _)| bumps_over(cases, other, clock));
    let judged = over.map(|over| Standing::of_times(&over, noise));
    let (standing, reason) =
        judged.unwrap_or((Standing::CannotTell, "The ladder was not timed.".to_owned()));
    let savings = bumps.zip(most).map(|((_, bumps), (name, ms))| {
        format!(
            "Removing bumps saves {} ms here, and of the others “{name}” most: {} ms.",
            significant(*bumps),
            significant(*ms)
        )
    });
    let parts = savings.into_iter().chain([reason]);
    let parts: Vec<String> = parts.filter(|part| !part.is_empty()).collect();
    Finding {
        claim: "Gebbie & Bailey: bump mapping costs most of the layers".to_owned(),
        standing,
        because: parts.join(" "),
    }
}

fn errors(caption: &str, cases: &[&Case], key: ConditionKey) -> Table {
    let columns = [
        ("largest", GLOBE_SHADE_MAX),
        ("99 %", GLOBE_SHADE_P99),
        ("within 5° of a pole, largest", GLOBE_SHADE_POLAR_MAX),
        ("99 %", GLOBE_SHADE_POLAR_P99),
        ("not finite", GLOBE_NON_FINITE),
    ];
    by_case(
        caption,
        cases,
        (&["view", key.name()], &conditions(&[VIEW, key])),
        &columns,
        &|_| "no pixel is there",
    )
}

fn pole_finding(cases: &[&Case]) -> Finding {
    let polar = |pictures: &str| {
        let mut own = cases.iter().filter(|case| {
            case.condition(VIEW) == "globe-pole" && case.condition(PICTURES) == pictures
        });
        own.next()
            .and_then(|case| value(case, GLOBE_SHADE_POLAR_P99))
    };
    let pair = polar("cube").zip(polar("angles"));
    Finding {
        claim: "Gebbie & Bailey: cube maps mend what pictures by angles do at the poles".to_owned(),
        standing: match pair {
            Some((cube, angles)) => Standing::holds_if(cube < angles),
            None => Standing::CannotTell,
        },
        because: match pair {
            Some((cube, angles)) => format!(
                "Within 5° of the pole 99 % of the pixels are off by at most {} with cube maps and {} with pictures by \
                 angles. Bumps are stored along parallels, whose direction turns once round the pole in either.",
                significant(cube),
                significant(angles)
            ),
            None => "The pole was not drawn.".to_owned(),
        },
    }
}

fn fault_finding(cases: &[&Case]) -> Finding {
    let words: Vec<String> = FAULTS
        .iter()
        .map(|(_, name)| {
            let own = cases.iter().filter(|case| case.condition(FAULT) == *name);
            let own: Vec<&&Case> = own.collect();
            let lost: f64 = own
                .iter()
                .filter_map(|case| case.value(GLOBE_NON_FINITE))
                .sum();
            let worst = own
                .iter()
                .filter_map(|case| case.value(GLOBE_SHADE_MAX))
                .max_by(f64::total_cmp);
            match worst {
                Some(worst) => format!(
                    "{name}: {lost} pixels not finite, off by up to {}",
                    significant(worst)
                ),
                None => format!("{name}: {lost} pixels not finite"),
            }
        })
        .collect();
    let shows = cases.iter().any(|case| {
        case.value(GLOBE_NON_FINITE).is_some_and(|lost| lost > 0.0)
            || case
                .value(GLOBE_SHADE_MAX)
                .is_some_and(|worst| worst > super::ALLOWED)
    });
    Finding {
        claim: "The shader as printed is wrong here: an undeclared variable, a power of what is negative, a tangent of no \
                length, night by the negated light"
            .to_owned(),
        standing: match cases.is_empty() {
            true => Standing::CannotTell,
            false => Standing::holds_if(shows),
        },
        because: format!("The first does not compile. {}.", words.join("; ")),
    }
}

fn pictures(cases: &[&Case]) -> Option<Block> {
    let shown = cases.iter().filter(|case| !case.note("picture").is_empty());
    let figures: Vec<PictureFigure> = shown
        .map(|case| PictureFigure {
            pictures: vec![Picture {
                path: case.note("picture").to_owned(),
                caption: match case.condition(WHAT) {
                    "projections" => case.condition(PROJECTION).to_owned(),
                    "faults" => case.condition(FAULT).to_owned(),
                    "pictures" => case.condition(PICTURES).to_owned(),
                    _ => format!("{} removed", case.condition(REMOVED)),
                },
            }],
            notes: vec![case.condition(VIEW).to_owned()],
        })
        .collect();
    (!figures.is_empty()).then(|| {
        Block::Pictures(Pictures {
            caption: "Layers and projections as drawn; what is not finite is magenta.".to_owned(),
            reference: String::new(),
            figures,
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_results::made_up::{MadeUpRun, case_id};

    /// The finding on a ladder whose frame lasts 10 ms, with a repeat that lasts 2 % longer. Clouds save 0.1 ms,
    /// bumps as much and `more`.
    fn found(more: f64, processes: usize) -> Finding {
        let metric = crate::clock::draw(Clock::ProcessCpu);
        let mut ms = 10.0;
        let mut run = MadeUpRun::default();
        for (place, (name, _)) in TABLE_3.iter().enumerate() {
            ms -= match *name {
                "Clouds" => 0.1,
                BUMPS => 0.1 + more,
                _ => 0.0,
            };
            let conditions = [("part", super::super::PART), ("what", "ladder")];
            let id = case_id(crate::STUDY, &place.to_string(), &conditions);
            if place == 0 {
                let longer = vec![1.02 * ms; processes];
                run.case(id.twin()).timed(metric, &longer);
            }
            run.case(id).timed(metric, &vec![ms; processes]);
        }
        let folder = tempfile::tempdir().expect("a folder");
        let run = run.write(folder.path()).expect("a run");
        let noise = noise(&run, Clock::ProcessCpu);
        bump_finding(&cases(&run, "ladder"), Clock::ProcessCpu, noise)
    }

    #[test]
    fn savings_within_the_noise_decide_nothing() {
        // By 0.00019 ms, where identical frames differ by 0.2 ms.
        for more in [0.000_19, -0.000_19, 0.15] {
            let found = found(more, 5);
            assert_eq!(found.standing, Standing::CannotTell, "{found:?}");
            assert!(
                found.because.contains("by which identical work differed"),
                "{found:?}"
            );
        }
        // Controls: beyond it either way, and too few processes for any.
        assert_eq!(found(1.0, 5).standing, Standing::Holds);
        assert_eq!(found(-1.0, 5).standing, Standing::DoesNotHold);
        assert_eq!(found(1.0, 3).standing, Standing::CannotTell);
    }
}
