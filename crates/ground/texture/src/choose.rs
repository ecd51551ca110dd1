// SPDX-License-Identifier: MIT OR Apache-2.0
//! The chooser: the cheapest route that is accurate enough for a region, a texture and a view.
//!
//! Accurate enough: the computed residual's root mean square is within a quarter of a texel along
//! each axis and a quarter of a pixel on the ground, longitudes on their own parallels, and its maximum
//! within half a texel along each axis. Routes are looked at from the cheapest up, so what a scene does
//! not need is never computed. Every route that was not taken is listed with the reason.
//!
//! The region asked about need not be all that a texture covers: what a view can see of it is enough,
//! with the anchor below the eye. Offsets and angles are then small where pixels are small. A picture
//! of a whole continent keeps a hundredth of a pixel 20 m above the ground, where an anchor one degree
//! away loses a pixel (`tests/choose_from_pixels.rs`). The difference between that anchor and the
//! texture's edge is a constant, computed in `f64`.

use crate::residual::RESIDUAL_SAMPLES;
use crate::{
    AngleCore, Chart, CoordinateRoute, MapRegion, Operations, Program, Residual, ResidualSum,
    Sample, SuiteCell, SuiteFinding, Weight,
};
use std::fmt;

/// Largest root mean square error, in texels along each axis and in pixels.
pub const RMS_TOLERANCE: f64 = 0.25;

/// Largest error in texels along each axis.
pub const MAX_TOLERANCE: f64 = 0.5;

/// Samples after which a route is looked at, and by how much its root mean square must then be over the
/// tolerance to be left out. That of few samples may lie on either side of that of all.
const LOOKS: [(usize, f64); 3] = [(60, 4.0), (400, 1.5), (usize::MAX, 1.0)];

impl Operations {
    /// What one evaluation costs, in fused multiply-adds. Changes of sign are free: they modify an operand.
    ///
    /// Orders, not measurements of one device: reciprocal and square root run at a quarter of the rate
    /// on all current GPUs, and a division is a reciprocal and a product. The native arctangent is a
    /// polynomial of degree 11 with octants and special cases (Mesa, `nir_builtin_builder.c`), two
    /// dozen operations and a division. A texture fetch has a latency of hundreds of cycles, and was
    /// 1.6 to 4.4 times as slow as the native arctangent where it was measured.
    #[must_use]
    pub fn cost(&self) -> f64 {
        [
            (self.add_mul_fma, 1.0),
            (self.divisions, 5.0),
            (self.compares_selects, 1.0),
            (self.sqrt, 4.0),
            (self.transcendental, 30.0),
            (self.texture_fetches, 100.0),
        ]
        .into_iter()
        .map(|(count, cost)| f64::from(count) * cost)
        .sum()
    }
}

/// What a route is chosen for.
#[derive(Debug, Clone, Copy)]
pub struct Demand {
    /// Where.
    pub region: MapRegion,
    /// Columns and rows of the texture that is laid over the region's extent.
    pub texture_size: [u32; 2],
    /// Size of a pixel on the ground at the nearest point of the region that is seen, metres.
    pub pixel_m: f64,
}

/// Why a route was not taken.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Reason {
    /// Root mean square error too large for the texture, texels.
    RmsTexels {
        /// Computed.
        found: f64,
        /// Allowed.
        allowed: f64,
    },
    /// Largest error too large for the texture, texels.
    MaxTexels {
        /// Computed.
        found: f64,
        /// Allowed.
        allowed: f64,
    },
    /// Root mean square error too large on the screen, pixels.
    RmsPixels {
        /// Computed.
        found: f64,
        /// Allowed.
        allowed: f64,
    },
    /// No finite answer or bound somewhere in the region.
    NonFinite {
        /// Samples.
        found: u32,
    },
    /// The suite measured more than the bound, or results that are not finite.
    Suite {
        /// Largest measured error over its bound.
        worst_over_bound: f64,
        /// Results that were not finite.
        non_finite: u64,
        /// Where.
        cell: SuiteCell,
    },
    /// Costs at least as much as the route taken; its residual was not computed.
    Dearer {
        /// Cost of the route taken.
        taken: f64,
    },
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::RmsTexels { found, allowed } => {
                write!(f, "RMS {found:.3} texels, allowed {allowed}")
            }
            Self::MaxTexels { found, allowed } => {
                write!(f, "maximum {found:.3} texels, allowed {allowed}")
            }
            Self::RmsPixels { found, allowed } => {
                write!(f, "RMS {found:.3} pixels, allowed {allowed}")
            }
            Self::NonFinite { found } => write!(f, "not finite at {found} places"),
            Self::Suite {
                worst_over_bound,
                non_finite,
                cell,
            } => write!(
                f,
                "the suite measured {worst_over_bound:.3} of its bound, {non_finite} results not finite \
                 ({cell})"
            ),
            Self::Dearer { taken } => write!(f, "costs no less than {taken:.0}"),
        }
    }
}

/// A route that was looked at.
#[derive(Debug, Clone, PartialEq)]
pub struct Considered {
    /// The route.
    pub route: CoordinateRoute,
    /// In fused multiply-adds.
    pub cost: f64,
    /// Where it was computed; from few samples where those were enough to leave the route out.
    pub residual: Option<Residual>,
}

/// What was chosen and what was not.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    /// The cheapest route within all tolerances, or `None` where there is none.
    pub chosen: Option<Considered>,
    /// All others with the reason, the cheapest first.
    pub left_out: Vec<(Considered, Reason)>,
}

impl Choice {
    /// What to draw with: the route chosen, or else, outside the tolerances, the one with the
    /// smallest computed error that the suite does not contradict.
    #[must_use]
    pub fn best_effort(&self) -> Option<&Considered> {
        let error = |c: &Considered| c.residual.map_or(f64::INFINITY, |r| r.max_m);
        self.chosen.as_ref().or_else(|| {
            self.left_out
                .iter()
                .filter(|(_, reason)| {
                    !matches!(reason, Reason::NonFinite { .. } | Reason::Suite { .. })
                })
                .map(|(considered, _)| considered)
                .filter(|considered| error(considered).is_finite())
                .min_by(|a, b| error(a).total_cmp(&error(b)))
        })
    }
}

/// Chooses among candidates.
#[derive(Debug, Clone)]
pub struct Chooser {
    /// With their programs and costs, the cheapest first.
    candidates: Vec<(f64, CoordinateRoute, Program)>,
    findings: Vec<SuiteFinding>,
}

impl Chooser {
    /// Among `candidates`; of routes with the same cost the one named first is taken.
    ///
    /// - `findings`: what the suite found; a route without a finding is trusted to its bound
    #[must_use]
    pub fn new(candidates: &[CoordinateRoute], findings: Vec<SuiteFinding>) -> Self {
        let mut candidates: Vec<_> = candidates
            .iter()
            .map(|route| {
                let program = route.program();
                (program.operations().cost(), *route, program)
            })
            .collect();
        candidates.sort_by(|a, b| a.0.total_cmp(&b.0));
        Self {
            candidates,
            findings,
        }
    }

    /// Routes that may be worth taking anywhere: charts, and angles in every form by the cores on the
    /// front of error against operations.
    ///
    /// Left out beforehand are the device's own arctangent, whose only bound is WGSL's 4096 ULP, and
    /// everything that reads a texture, which costs more and is less accurate. Barycentric coordinates
    /// are left out too, since a gnomonic chart of degree 1 is as flat, costs less and errs less.
    #[must_use]
    pub fn default_candidates() -> Vec<CoordinateRoute> {
        CoordinateRoute::all()
            .into_iter()
            .filter(|route| match route {
                CoordinateRoute::Chart(chart) => {
                    !matches!(chart, Chart::Cube(_) | Chart::Barycentric)
                }
                CoordinateRoute::Angles { core, .. } => matches!(
                    core,
                    AngleCore::Odd {
                        weight: Weight::Absolute,
                        ..
                    } | AngleCore::Rational {
                        weight: Weight::Absolute,
                        ..
                    }
                ),
            })
            .collect()
    }

    /// What a frame plan asks: the default candidates, less what the suite has against them.
    #[must_use]
    pub fn of_plan() -> Self {
        Self::new(&Self::default_candidates(), SuiteFinding::checked_in())
    }

    /// Takes the cheapest candidate within the tolerances.
    #[must_use]
    pub fn choose(&self, demand: &Demand) -> Choice {
        let samples: Vec<Sample> = demand.region.samples(RESIDUAL_SAMPLES).collect();
        let mut choice = Choice {
            chosen: None,
            left_out: Vec::new(),
        };
        for (cost, route, program) in &self.candidates {
            let considered = |residual| Considered {
                route: *route,
                cost: *cost,
                residual,
            };
            if let Some(taken) = &choice.chosen {
                let reason = Reason::Dearer { taken: taken.cost };
                choice.left_out.push((considered(None), reason));
                continue;
            }
            if let Some(reason) = self.contradicted(*route, &demand.region) {
                choice.left_out.push((considered(None), reason));
                continue;
            }
            let constants = route.constants(&demand.region);
            let (residual, reason) = demand.judge(program, &constants, &samples);
            match reason {
                Some(reason) => choice.left_out.push((considered(Some(residual)), reason)),
                None => choice.chosen = Some(considered(Some(residual))),
            }
        }
        choice
    }

    /// What the suite has against a route in regions like this one.
    fn contradicted(&self, route: CoordinateRoute, region: &MapRegion) -> Option<Reason> {
        self.findings
            .iter()
            .filter(|finding| finding.route == route && finding.cell.covers(region))
            .find(|finding| finding.contradicts())
            .map(|finding| Reason::Suite {
                worst_over_bound: finding.worst_over_bound,
                non_finite: finding.non_finite,
                cell: finding.cell,
            })
    }
}

impl Demand {
    /// Radians per texel along longitude and latitude.
    #[must_use]
    pub fn texel_rad(&self) -> [f64; 2] {
        let size = self.region.extent().size_rad();
        [0, 1].map(|axis: usize| size[axis] / f64::from(self.texture_size[axis].max(1)))
    }

    /// What speaks against a residual, the texture before the screen.
    #[must_use]
    pub fn objection(&self, residual: &Residual) -> Option<Reason> {
        if residual.non_finite > 0 || !residual.max_rad.is_finite() {
            let found = residual.non_finite;
            return Some(Reason::NonFinite { found });
        }
        let texel = self.texel_rad();
        let texels = |rad: [f64; 2]| (rad[0] / texel[0]).max(rad[1] / texel[1]);
        let rms = texels(residual.rms_axis_rad);
        let max = texels(residual.max_axis_rad);
        let pixels = residual.rms_m / self.pixel_m;
        if rms > RMS_TOLERANCE {
            Some(Reason::RmsTexels {
                found: rms,
                allowed: RMS_TOLERANCE,
            })
        } else if max > MAX_TOLERANCE {
            Some(Reason::MaxTexels {
                found: max,
                allowed: MAX_TOLERANCE,
            })
        } else if pixels > RMS_TOLERANCE {
            Some(Reason::RmsPixels {
                found: pixels,
                allowed: RMS_TOLERANCE,
            })
        } else {
            None
        }
    }

    /// The residual and what speaks against it, from as few samples as decide it.
    fn judge(
        &self,
        program: &Program,
        constants: &[[f32; 4]],
        samples: &[Sample],
    ) -> (Residual, Option<Reason>) {
        let mut sum = ResidualSum::default();
        let mut taken = 0;
        for (look, slack) in LOOKS {
            let end = look.min(samples.len());
            for sample in &samples[taken..end] {
                sum.add(sample, program.bounded(constants, sample.offset_m));
            }
            taken = end;
            let residual = sum.clone().finish();
            let reason = self.objection(&residual);
            let certain = match &reason {
                // Maxima only grow.
                Some(Reason::MaxTexels { .. } | Reason::NonFinite { .. }) => true,
                Some(Reason::RmsTexels { found, .. } | Reason::RmsPixels { found, .. }) => {
                    *found > slack * RMS_TOLERANCE
                }
                _ => false,
            };
            if reason.is_none() && taken == samples.len() {
                // What is said of a route that is taken is said of all places.
                sum.raise_to_peak(&self.region, |sample| {
                    program.bounded(constants, sample.offset_m)
                });
                return (sum.finish(), None);
            }
            if certain || taken == samples.len() {
                return (residual, reason);
            }
        }
        let residual = sum.finish();
        (residual, self.objection(&residual))
    }
}
