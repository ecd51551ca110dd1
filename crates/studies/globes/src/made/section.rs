// SPDX-License-Identifier: MIT OR Apache-2.0
//! The section on vertices made on the GPU, and on the paper's static buffer.

use super::{ALLOWED_PX, PART};
use crate::metrics::{self, *};
use terrafill_globe_views::{DRAW, FRAME, whole};
use terrafill_lab::{Cases, Column, Comparison, Follows, Names, Section, Select, finding};
use terrafill_plot::number::significant;
use terrafill_results::{Block, Case, ChapterError, Claim, Finding, Scope};

pub(crate) const SECTION: Section<'static> = Section {
    title: "Vertices made on the GPU",
    text: "A spiral of 72 vertices a turn by the focus-local form, from the fan to the horizon. Its vertices are sent \
           by the CPU, or made by a compute shader into the buffer that is drawn, or by the vertex stage from their \
           number. Or they lie in one static buffer of sine, cosine and radius, as the paper has it. Of it draw arguments \
           choose a range; the vertex stage corrects the radius by a square root and turns a hemisphere to the focus. \
           Vertices are read back and held against f64; the vertex stage's picture is held to the compute shader's to \
           the bit. Native sines and cosines have a bound of 2^-11 in WGSL, 3 km on the Earth; series of ninth and \
           tenth order have one of their own. Over terrain each vertex is moved up by a height that it looks up where \
           it is, on the faces of a cube, which the paper leaves to the future. By its direction from the body's \
           centre, in f32, a vertex is half a metre off and its height with it. Locally it goes by its way from the \
           ground below the eye: heights and normals are differences from those there.",
    cases: Select::With(metrics::PART, PART),
    named_by: Names::Columns(&[
        ("view", VIEW),
        ("vertices", VERTICES),
        ("trigonometry", TRIG),
        ("law", LAW),
        ("heights", HEIGHTS),
        ("looked up", LOOKUP),
    ]),
    columns: &[
        Column::metric("sent a frame", GLOBE_UPLOAD_BYTES),
        Column::metric("px off f64, largest", GLOBE_MADE_PX_MAX),
        Column::metric("m off f64, largest", GLOBE_MADE_M_MAX),
        Column::metric("px that differ from compute's", GLOBE_MADE_DIFFERS_PX),
        Column::metric("vertices", GLOBE_VERTICES),
        FRAME,
        Column::metric("make and send, CPU ms", GLOBE_UPLOAD_CPU_MS),
        DRAW,
    ],
    findings: &[same_as_compute, static_is_faster, sends_constants],
    more: &[displaced],
    ..Section::EMPTY
};

fn same_as_compute(cases: &Cases<'_>) -> Finding {
    let differs = ["number", "static"].map(|of| cases.with(&[(VERTICES, of)]));
    let differs = differs
        .map(|cases| cases.values(GLOBE_MADE_DIFFERS_PX))
        .concat();
    let words = ["native", "series"].into_iter().filter_map(|trig| {
        let own = [(TRIG, trig), (VERTICES, "compute"), (HEIGHTS, "none")];
        let worst = cases.with(&own).greatest(GLOBE_MADE_PX_MAX)?;
        Some(format!("{trig}: {} px off at most", significant(worst)))
    });
    finding(
        "Vertices made by the vertex stage are those of the compute shader, to the pixel",
        (!differs.is_empty()).then(|| differs.iter().all(|px| *px == 0.0)),
        format!(
            "{} pixels differ in {} pictures. Against f64, {}.",
            differs.iter().sum::<f64>(),
            differs.len(),
            words.collect::<Vec<_>>().join(", ")
        ),
    )
}

/// The paper's thesis: geometry that is never altered, projected on the GPU, against geometry that the CPU sends.
const STATIC: Comparison<'static> = Comparison {
    changed: VERTICES.name(),
    follows: &[Follows {
        key: TRIG.name(),
        because: "the CPU has sines of its own",
    }],
    one_sided: None,
    metric: GLOBE_WHOLE_CPU_MS,
    needs: Scope::PLAN.and(Scope::DRAW),
};

fn static_is_faster(cases: &Cases<'_>) -> Finding {
    let of = |view: &str, vertices: &str| {
        let own = [
            (VIEW, view),
            (VERTICES, vertices),
            (LAW, "published"),
            (HEIGHTS, "none"),
        ];
        cases.with(&own).first()
    };
    let views = cases.by(VIEW).into_iter();
    let pairs = views.filter_map(|(view, _)| Some([of(view, "sent")?, of(view, "static")?]));
    let pairs: Vec<[&Case; 2]> = pairs.collect();
    cases.compared(
        &Comparison {
            metric: whole(cases.clock()),
            ..STATIC
        },
        &pairs,
        Claim::Faster,
        "Gebbie & Bailey: a static buffer that the vertex stage projects takes less than vertices made and sent for \
         each frame"
            .to_owned(),
    )
}

/// Of what the CPU's own mesh sends, what constants alone are well below.
const CONSTANTS_SHARE: f64 = 0.1;

fn sends_constants(cases: &Cases<'_>) -> Finding {
    let of = |vertices: &str| {
        let all = cases.with(&[(VERTICES, vertices), (HEIGHTS, "none")]);
        all.greatest(GLOBE_UPLOAD_BYTES)
    };
    let pair = of("static").zip(of("sent"));
    finding(
        "With a static buffer a frame sends less than a tenth of what the CPU's own mesh takes",
        pair.map(|(fixed, sent)| fixed < CONSTANTS_SHARE * sent),
        pair.map_or_else(String::new, |(fixed, sent)| {
            format!(
                "{} bytes, all of them constants, against at most {}.",
                significant(fixed),
                significant(sent)
            )
        }),
    )
}

/// What looking heights up in f32 costs on the ground; nothing where no vertex was displaced.
fn displaced(cases: &Cases<'_>) -> Result<Option<Block>, ChapterError> {
    let near = [(LOOKUP, "absolute"), (VIEW, "ground-1.7m")];
    let absolute = cases.with(&near).greatest(GLOBE_MADE_PX_MAX);
    let local = cases.with(&[(LOOKUP, "local")]).greatest(GLOBE_MADE_PX_MAX);
    let found = absolute.zip(local).map(|(absolute, local)| {
        finding(
            "Vertices displaced in the vertex stage stay where f64 puts them if heights are looked up locally",
            Some(local <= ALLOWED_PX),
            format!(
                "Locally they are {} px off at most in all views. By directions from the centre they are {} px off at \
                 1.7 m.",
                significant(local),
                significant(absolute)
            ),
        )
    });
    Ok(found.map(Block::Finding))
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrafill_results::made_up::{MadeUpRun, case_id};
    use terrafill_results::{Clock, Standing};

    /// Vertices of the CPU's take 2 ms, or 1 % more when measured again; those of the static buffer `ms`.
    fn standing(ms: f64, law: &str) -> Standing {
        let mut made = MadeUpRun::default();
        let metric = whole(Clock::ProcessCpu);
        for (vertices, trig, ms) in [("sent", "native", 2.0), ("static", "series", ms)] {
            let conditions = [
                ("part", PART),
                ("view", "globe"),
                ("vertices", vertices),
                ("trig", trig),
                ("law", law),
                ("heights", "none"),
            ];
            let id = case_id(crate::STUDY, vertices, &conditions);
            made.case(id.repeat()).timed(metric, &[1.01 * ms; 5]);
            made.case(id).timed(metric, &[ms; 5]);
        }
        static_is_faster(&Cases::of_study(&made.loaded(), crate::STUDY)).standing
    }

    #[test]
    fn a_static_buffer_is_faster_only_beyond_the_noise() {
        assert_eq!(standing(1.0, "published"), Standing::Holds);
        // Negative controls: slower, within the noise, and another law.
        assert_eq!(standing(4.0, "published"), Standing::DoesNotHold);
        assert_eq!(standing(1.995, "published"), Standing::NoDifference);
        assert_eq!(standing(1.0, "quadratic"), Standing::NotMeasured);
    }
}
