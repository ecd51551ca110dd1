// SPDX-License-Identifier: MIT OR Apache-2.0
//! The chooser: the cheapest route that is accurate enough for a region, a texture and a view.
//!
//! Accurate enough: the computed residual's root mean square is within a quarter of a texel along
//! each axis and a quarter of a pixel on the ground, and its maximum within half a texel along each
//! axis. Routes are looked at from the cheapest up, so what a scene does not need is never computed.
//! Every route that was not taken is listed with the reason.

use crate::residual::{RESIDUAL_SAMPLES, residual_of};
use crate::{CoordinateRoute, MapRegion, Operations, Residual};

/// Largest root mean square error, in texels along each axis and in pixels.
pub const RMS_TOLERANCE: f64 = 0.25;

/// Largest error in texels along each axis.
pub const MAX_TOLERANCE: f64 = 0.5;

/// Samples of a first look: a route that fails at these few places fails at all of them.
const FIRST_LOOK: u32 = 48;

/// What operations cost in units of one fused multiply-add.
///
/// Orders, not measurements of one device: reciprocal and square root run at a quarter of the rate
/// on all current GPUs, and a division is a reciprocal and a product; the native arctangent is a
/// polynomial of degree 11 with octants and special cases (Mesa, `nir_builtin_builder.c`), two
/// dozen operations and a division; a texture fetch has a latency of hundreds of cycles, and was
/// 1.6 to 4.4 times as slow as the native arctangent where it was measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CostTable {
    /// Sum, product or fused both.
    pub add_mul_fma: f64,
    /// Division.
    pub division: f64,
    /// Comparison, select, minimum or maximum.
    pub compare_select: f64,
    /// Square root.
    pub sqrt: f64,
    /// The device's own arctangent.
    pub transcendental: f64,
    /// Texture fetch.
    pub texture_fetch: f64,
}

impl Default for CostTable {
    fn default() -> Self {
        Self {
            add_mul_fma: 1.0,
            division: 5.0,
            compare_select: 1.0,
            sqrt: 4.0,
            transcendental: 30.0,
            texture_fetch: 100.0,
        }
    }
}

impl CostTable {
    /// Cost of one evaluation, in fused multiply-adds. Changes of sign are free: they modify an
    /// operand.
    #[must_use]
    pub fn cost(&self, operations: &Operations) -> f64 {
        [
            (operations.add_mul_fma, self.add_mul_fma),
            (operations.divisions, self.division),
            (operations.compares_selects, self.compare_select),
            (operations.sqrt, self.sqrt),
            (operations.transcendental, self.transcendental),
            (operations.texture_fetches, self.texture_fetch),
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

/// What the numerical suite found about a route, on whichever device.
#[derive(Debug, Clone, PartialEq)]
pub struct SuiteFinding {
    /// The route.
    pub route: CoordinateRoute,
    /// Largest measured error over its computed bound; above 1 the bound does not hold there.
    pub worst_over_bound: f64,
    /// Results that were not finite.
    pub non_finite: u64,
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
    },
    /// Costs at least as much as the route taken; its residual was not computed.
    Dearer {
        /// Cost of the route taken.
        taken: f64,
    },
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
    /// Routes that may be taken.
    pub candidates: Vec<CoordinateRoute>,
    /// What operations cost.
    pub costs: CostTable,
    /// What the suite found; a route without a finding is trusted to its bound.
    pub findings: Vec<SuiteFinding>,
}

impl Chooser {
    /// Takes the cheapest candidate within the tolerances.
    ///
    /// Of routes with the same cost the one named first is taken.
    #[must_use]
    pub fn choose(&self, demand: &Demand) -> Choice {
        let mut by_cost: Vec<(f64, CoordinateRoute)> = self
            .candidates
            .iter()
            .map(|route| (self.costs.cost(&route.operations()), *route))
            .collect();
        by_cost.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut choice = Choice {
            chosen: None,
            left_out: Vec::new(),
        };
        for (cost, route) in by_cost {
            let considered = |residual| Considered {
                route,
                cost,
                residual,
            };
            if let Some(taken) = &choice.chosen {
                let reason = Reason::Dearer { taken: taken.cost };
                choice.left_out.push((considered(None), reason));
                continue;
            }
            if let Some(reason) = self.contradicted(route) {
                choice.left_out.push((considered(None), reason));
                continue;
            }
            let (residual, reason) = demand.judge(route);
            match reason {
                Some(reason) => choice.left_out.push((considered(Some(residual)), reason)),
                None => choice.chosen = Some(considered(Some(residual))),
            }
        }
        choice
    }

    /// What the suite has against a route.
    fn contradicted(&self, route: CoordinateRoute) -> Option<Reason> {
        self.findings
            .iter()
            .filter(|finding| finding.route == route)
            // A ratio that is NaN speaks against the route too.
            .find(|finding| finding.non_finite > 0 || !(finding.worst_over_bound <= 1.0))
            .map(|finding| Reason::Suite {
                worst_over_bound: finding.worst_over_bound,
                non_finite: finding.non_finite,
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
        let pixels = self.ground_m(residual.rms_axis_rad) / self.pixel_m;
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

    /// Angles as a distance on the ground, along the widest parallel of the extent, metres.
    fn ground_m(&self, rad: [f64; 2]) -> f64 {
        let extent = self.region.extent();
        let widest = if extent.south_rad < 0.0 && extent.north_rad > 0.0 {
            0.0
        } else {
            extent.south_rad.abs().min(extent.north_rad.abs())
        };
        let radius = self.region.body().equatorial_radius_m();
        // The largest radius of curvature, a²/b: of the prime vertical and the meridian at a pole.
        let largest = radius * radius / self.region.body().polar_radius_m();
        (rad[0] * largest * widest.cos()).hypot(rad[1] * largest)
    }

    /// The residual and what speaks against it.
    fn judge(&self, route: CoordinateRoute) -> (Residual, Option<Reason>) {
        let program = route.program();
        let constants = route.constants(&self.region);
        let look = |samples| {
            let residual = residual_of(&program, &constants, &self.region, samples);
            let reason = self.objection(&residual);
            (residual, reason)
        };
        match look(FIRST_LOOK) {
            // A root mean square of few samples may lie on either side; a maximum only grows.
            (residual, Some(reason @ (Reason::MaxTexels { .. } | Reason::NonFinite { .. }))) => {
                (residual, Some(reason))
            }
            (residual, Some(reason @ (Reason::RmsTexels { found, .. } | Reason::RmsPixels { found, .. })))
                if found > 4.0 * RMS_TOLERANCE =>
            {
                (residual, Some(reason))
            }
            _ => look(RESIDUAL_SAMPLES),
        }
    }
}
