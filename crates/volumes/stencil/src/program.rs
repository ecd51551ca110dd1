// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a fill does, step by step, before any graphics API is chosen.
//!
//! Every volume backend walks through the same program, so a switch means the same for a vertex
//! shader on wgpu and a geometry shader on ash, and two rows that differ in one switch differ in
//! nothing else.

use crate::Volume;
use crate::batches::{ordered_batches, overlap_depth, xor_batches};
use terrafill_contract::DeviceError;
use terrafill_plan::{DrawnAs, NearRectangle};
use terrafill_scene::Overlap;
use terrafill_variant::{
    BottomCap, ColourWay, CoverArea, DepthRuleChoice, FacePasses, FirstPass, StencilClear,
    SwitchError, Switches,
};

/// Which fragments of a volume touch the stencil.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum DepthRule {
    /// Those that fail the depth test: behind the surface.
    Fail,
    /// Those that pass it: in front.
    Pass,
    /// All, as with [`DepthRule::Fail`]: the first step of a stencil that is preloaded.
    Always,
}

/// Faces of a closed volume, seen from the eye.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum FaceSet {
    /// All.
    Both,
    /// Those that look at the eye.
    Front,
    /// Those that look away.
    Back,
}

/// What a touching fragment does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum StencilOperation {
    /// Flips the bits of `mask`, whichever way the face looks: a closed volume leaves them flipped
    /// exactly inside.
    Invert {
        /// Bits that are flipped; the stencil's write mask.
        mask: u8,
    },
    /// Adds or takes away one, modulo 256: with [`DepthRule::Fail`] and [`DepthRule::Always`] back faces
    /// add and front faces take away, with [`DepthRule::Pass`] the other way round.
    Count,
}

/// State of a draw that marks the inside of volumes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct StencilRule {
    /// Which fragments touch the stencil.
    pub depth: DepthRule,
    /// What they do.
    pub operation: StencilOperation,
    /// Faces that are drawn; the others are culled.
    pub faces: FaceSet,
}

/// What a touching fragment of one kind of face does to the bits that are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FaceEffect {
    /// Flips them.
    Invert,
    /// Adds one, modulo 256.
    Add,
    /// Takes one away, modulo 256.
    Take,
}

impl StencilRule {
    /// What front and back faces do, and the bits that are written.
    #[must_use]
    pub fn effects(self) -> (FaceEffect, FaceEffect, u8) {
        match (self.operation, self.depth) {
            (StencilOperation::Invert { mask }, _) => {
                (FaceEffect::Invert, FaceEffect::Invert, mask)
            }
            (StencilOperation::Count, DepthRule::Fail | DepthRule::Always) => {
                (FaceEffect::Take, FaceEffect::Add, 0xff)
            }
            (StencilOperation::Count, DepthRule::Pass) => (FaceEffect::Add, FaceEffect::Take, 0xff),
        }
    }
}

/// State of a draw that colours marked pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct StencilTest {
    /// Passes where stencil and reference, both masked, are equal; otherwise where they differ.
    pub is_equal: bool,
    /// Compared with.
    pub reference: u8,
    /// Bits compared.
    pub read_mask: u8,
    /// A coloured pixel's stencil becomes 0.
    pub zeroes: bool,
    /// Passes only where there is a surface. Covers of this kind are drawn at depth 0, the sky's.
    pub skips_sky: bool,
}

impl StencilTest {
    /// Whatever the stencil says, which stays as it is.
    pub const ANYWHERE: Self = Self {
        is_equal: true,
        reference: 0,
        read_mask: 0,
        zeroes: false,
        skips_sky: false,
    };
}

/// What brings the colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum CoverShape {
    /// One triangle over the screen, cut to the volume's rectangle.
    Rectangle,
    /// One triangle over the screen.
    Screen,
    /// The volume again, without depth test.
    Volume {
        /// Faces that are drawn.
        faces: FaceSet,
        /// Leaves out bottom caps.
        without_bottom: bool,
    },
    /// The volume's top cap and walls, where they face the eye and are nearer than the surface. The walls
    /// close what opens between neighbours whose caps differ in height: without them 87 pixels of 512² of
    /// `countries-110m`, view `globe`, belonged to nobody.
    Flat,
}

/// One step. Volumes are indices into a [`crate::VolumeList`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum FillCommand {
    /// Marks the inside of volumes. Their order changes nothing, so a backend may sort them by
    /// pipeline.
    Volumes {
        /// State.
        rule: StencilRule,
        /// Leaves out bottom caps.
        without_bottom: bool,
        /// Cuts each volume to its rectangle.
        scissor: bool,
        /// What is drawn.
        volumes: Vec<usize>,
    },
    /// Colours marked pixels, volume by volume in this order, each in its own colour;
    /// [`CoverShape::Screen`] draws once, in the first volume's.
    Cover {
        /// State.
        test: StencilTest,
        /// What is drawn.
        shape: CoverShape,
        /// Whose colours.
        volumes: Vec<usize>,
    },
    /// Adds to a 32-bit float target, cleared to 0 when the pass starts, each volume's number (its
    /// place in the list, plus 1) where a fragment counts. With [`DepthRule::Fail`] back faces add
    /// and front faces take away, with [`DepthRule::Pass`] the other way round. What is left is the
    /// number of the volume that the surface lies in. Their order changes nothing.
    Accumulate {
        /// Which fragments count.
        depth: DepthRule,
        /// Faces that are drawn; the others are culled.
        faces: FaceSet,
        /// Leaves out bottom caps.
        without_bottom: bool,
        /// Cuts each volume to its rectangle.
        scissor: bool,
        /// What is drawn.
        volumes: Vec<usize>,
    },
    /// Colours every pixel whose accumulated number is not 0 with that volume's colour, by one
    /// triangle over the screen.
    Resolve,
}

/// Steps between two barriers of the targets.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FillPass {
    /// The pass starts by setting the stencil to 0.
    pub clears_stencil: bool,
    /// The pass has a colour target; steps that only mark leave it alone.
    pub has_colour: bool,
    /// What fragments do beside marking, in a pass without that target.
    pub first_pass: FirstPass,
    /// In order.
    pub commands: Vec<FillCommand>,
}

impl FillCommand {
    /// What is drawn; nothing of [`FillCommand::Resolve`].
    fn volumes_mut(&mut self) -> &mut [usize] {
        match self {
            Self::Volumes { volumes, .. }
            | Self::Cover { volumes, .. }
            | Self::Accumulate { volumes, .. } => volumes,
            Self::Resolve => &mut [],
        }
    }
}

impl FillPass {
    /// Clears the stencil and marks; without colour.
    fn marking(commands: Vec<FillCommand>) -> Self {
        Self {
            clears_stencil: true,
            has_colour: false,
            first_pass: FirstPass::Stencil,
            commands,
        }
    }

    /// Colours what passes before it marked.
    fn colouring(commands: Vec<FillCommand>) -> Self {
        Self {
            clears_stencil: false,
            has_colour: true,
            ..Self::marking(commands)
        }
    }

    /// Whether the stencil is cleared, written or looked at.
    #[must_use]
    pub fn touches_stencil(&self) -> bool {
        let touches = |command: &FillCommand| match command {
            FillCommand::Volumes { .. } => true,
            FillCommand::Cover { test, .. } => test.read_mask != 0 || test.zeroes,
            FillCommand::Accumulate { .. } | FillCommand::Resolve => false,
        };
        self.clears_stencil || self.commands.iter().any(touches)
    }

    /// Whether the pass draws into the target of [`FillCommand::Accumulate`] and nothing else.
    #[must_use]
    pub fn accumulates(&self) -> bool {
        let accumulates = |command| matches!(command, &FillCommand::Accumulate { .. });
        self.commands.iter().any(accumulates)
    }
}

/// A fill.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct FillProgram {
    /// In order. None for no volumes.
    pub passes: Vec<FillPass>,
}

impl FillProgram {
    /// The steps that colour the inside of `volumes` with these switches.
    ///
    /// # Errors
    /// [`DeviceError::Switch`] when the switches do not go together or not with the scene;
    /// [`DeviceError::OverCapacity`] when more than 255 volumes may lie over one pixel and are
    /// counted together: a multiple of 256 would count as none; or when there are more volumes than
    /// numbers can be accumulated exactly.
    pub fn new(
        volumes: &[Volume],
        switches: &Switches,
        overlap: Overlap,
    ) -> Result<Self, DeviceError> {
        switches.check(overlap)?;
        let drawn_as = |what: DrawnAs| -> Vec<usize> {
            let all = 0..volumes.len();
            all.filter(|&index| volumes[index].drawn_as == what)
                .collect()
        };
        let [near, flat, ground] =
            [DrawnAs::Volume, DrawnAs::FlatMesh, DrawnAs::Ground].map(drawn_as);
        if near.len() == volumes.len() {
            return Self::of_volumes(volumes, switches, overlap);
        }
        for (regions, switch) in [(&flat, "far-level-px"), (&ground, "interior")] {
            if !regions.is_empty() {
                check_unmarked(switch, switches, overlap)?;
            }
        }
        let own: Vec<Volume> = near.iter().map(|&index| volumes[index]).collect();
        let mut program = Self::of_volumes(&own, switches, overlap)?;
        for command in program
            .passes
            .iter_mut()
            .flat_map(|pass| &mut pass.commands)
        {
            for index in command.volumes_mut() {
                *index = near[*index];
            }
        }
        program.add_unmarked(StencilTest::ANYWHERE, CoverShape::Flat, flat);
        program.add_unmarked(ON_GROUND, CoverShape::Rectangle, ground);
        Ok(program)
    }

    /// Of volumes that are drawn as such.
    fn of_volumes(
        volumes: &[Volume],
        switches: &Switches,
        overlap: Overlap,
    ) -> Result<Self, DeviceError> {
        let builder = Builder { volumes, switches };
        let passes = match switches.colour {
            _ if volumes.is_empty() => Vec::new(),
            ColourWay::Xor => builder.xor(),
            ColourWay::BitPlanes => builder.bit_planes(),
            ColourWay::Rectangle | ColourWay::Volume => builder.one_at_a_time(),
            ColourWay::OneColour | ColourWay::OneColourVolumes => {
                if overlap == Overlap::Ordered {
                    check_depth(volumes)?;
                }
                builder.one_colour()
            }
            ColourWay::IdAccumulation => {
                check_numbers(volumes.len())?;
                builder.id_accumulation()
            }
        };
        Ok(Self { passes })
    }

    /// Draws these in the last pass, which colours, or in one of their own.
    fn add_unmarked(&mut self, test: StencilTest, shape: CoverShape, volumes: Vec<usize>) {
        if volumes.is_empty() {
            return;
        }
        let command = FillCommand::Cover {
            test,
            shape,
            volumes,
        };
        match self.passes.last_mut() {
            Some(pass) => pass.commands.push(command),
            None => self.passes.push(FillPass::colouring(vec![command])),
        }
    }

    /// All steps in order: what a backend needs pipelines for.
    pub fn commands(&self) -> impl Iterator<Item = &FillCommand> {
        self.passes.iter().flat_map(|pass| &pass.commands)
    }
}

/// What needs no stencil is drawn after all volumes, by the regions' plain colours.
fn check_unmarked(
    switch: &'static str,
    switches: &Switches,
    overlap: Overlap,
) -> Result<(), DeviceError> {
    let refuse = |found: &str, allowed: &str| {
        Err(DeviceError::Switch(SwitchError {
            switch,
            found: format!("regions without volumes {found}"),
            allowed: allowed.to_owned(),
        }))
    };
    if overlap == Overlap::Ordered {
        return refuse(
            "in a scene with overlap=ordered",
            "off, or overlap=disjoint",
        );
    }
    if switches.texture.is_some() {
        return refuse("of a textured fill", "off, or a plain fill");
    }
    Ok(())
}

/// Volumes that an 8-bit count can hold over one pixel.
const COUNTABLE: usize = 255;

fn check_depth(volumes: &[Volume]) -> Result<(), DeviceError> {
    if volumes.len() <= COUNTABLE {
        return Ok(());
    }
    let what = "volumes over one pixel, counted together in 8 bits";
    DeviceError::check_capacity(what, overlap_depth(volumes) as u64, COUNTABLE as u64)
}

/// Volumes whose numbers a 32-bit float can accumulate. It holds integers to 2²⁴, and the sum of
/// 1 … 4,095 is half of that. So every order of adding is exact as long as no ray is inside more
/// than two sheets of every volume at once.
const ACCUMULABLE: usize = 4_095;

fn check_numbers(volumes: usize) -> Result<(), DeviceError> {
    let what = "volumes in view whose numbers are accumulated in 32-bit floats";
    DeviceError::check_capacity(what, volumes as u64, ACCUMULABLE as u64)
}

struct Builder<'a> {
    volumes: &'a [Volume],
    switches: &'a Switches,
}

impl Builder<'_> {
    fn all(&self) -> Vec<usize> {
        (0..self.volumes.len()).collect()
    }

    fn depth_rule(&self, volume: usize) -> DepthRule {
        match self.switches.depth_rule {
            DepthRuleChoice::Fail => DepthRule::Fail,
            DepthRuleChoice::Pass => DepthRule::Pass,
            DepthRuleChoice::Automatic => match self.volumes[volume].near_rectangle {
                NearRectangle::Outside => DepthRule::Pass,
                NearRectangle::Within | NearRectangle::Cut => DepthRule::Fail,
            },
            DepthRuleChoice::Uncut => match self.volumes[volume].near_rectangle {
                NearRectangle::Outside | NearRectangle::Within => DepthRule::Pass,
                NearRectangle::Cut => DepthRule::Fail,
            },
        }
    }

    /// Its fragments in front of the surface are counted from within, so that they mark what lies outside.
    fn marks_outside(&self, volume: usize) -> bool {
        self.switches.depth_rule == DepthRuleChoice::Uncut
            && self.volumes[volume].near_rectangle == NearRectangle::Within
    }

    /// Marks `volumes`, split by depth rule and, with two passes, by face.
    fn mark(&self, volumes: &[usize], operation: StencilOperation) -> Vec<FillCommand> {
        let (outside, inside): (Vec<usize>, Vec<usize>) = volumes
            .iter()
            .partition(|&&volume| self.marks_outside(volume));
        let split = |volumes: &[usize], scissor| {
            self.split(volumes, |depth, faces, without_bottom, volumes| {
                FillCommand::Volumes {
                    rule: StencilRule {
                        depth,
                        operation,
                        faces,
                    },
                    without_bottom,
                    scissor,
                    volumes,
                }
            })
        };
        let mut commands = split(&inside, self.switches.scissor);
        // Their rectangles hold what lies inside.
        commands.extend(split(&outside, false));
        commands
    }

    /// One command for each depth rule that a volume has and each set of faces.
    fn split(
        &self,
        volumes: &[usize],
        command: impl Fn(DepthRule, FaceSet, bool, Vec<usize>) -> FillCommand,
    ) -> Vec<FillCommand> {
        let faces: &[FaceSet] = match self.switches.faces {
            FacePasses::TwoSided => &[FaceSet::Both],
            FacePasses::TwoPass => &[FaceSet::Front, FaceSet::Back],
        };
        let mut commands = Vec::new();
        for depth in [DepthRule::Fail, DepthRule::Pass] {
            let of_rule: Vec<usize> = volumes
                .iter()
                .copied()
                .filter(|&volume| self.depth_rule(volume) == depth)
                .collect();
            let without_bottom =
                depth == DepthRule::Pass && self.switches.bottom_cap == BottomCap::WhereNeeded;
            if !of_rule.is_empty() {
                let each = |&faces| command(depth, faces, without_bottom, of_rule.clone());
                commands.extend(faces.iter().map(each));
            }
        }
        commands
    }

    /// Front faces suffice to cover a volume, except where the near plane cuts it; with an infinite
    /// far plane no back face is ever clipped.
    fn cover_faces(&self, volume: usize) -> FaceSet {
        match self.volumes[volume].near_rectangle {
            _ if !self.switches.cover_culls_faces => FaceSet::Both,
            NearRectangle::Outside => FaceSet::Front,
            NearRectangle::Within | NearRectangle::Cut => FaceSet::Back,
        }
    }

    /// How a volume's cover is drawn by the volume itself.
    fn cover_shape(&self, volume: usize) -> CoverShape {
        let may_be_inside = self.volumes[volume].near_rectangle != NearRectangle::Outside;
        CoverShape::Volume {
            faces: self.cover_faces(volume),
            without_bottom: self.switches.bottom_cap != BottomCap::Always && !may_be_inside,
        }
    }

    fn xor(&self) -> Vec<FillPass> {
        let mut passes = Vec::new();
        let numbers = u8::MAX >> (u8::BITS - u32::from(self.switches.stencil_bits()));
        for classes in xor_batches(self.volumes, numbers) {
            let numbered = || (1..=u8::MAX).zip(&classes);
            // Bits that no number has stay 0 and are not looked at.
            let largest = u8::try_from(classes.len()).unwrap_or(u8::MAX);
            let bits = u8::MAX.checked_shr(largest.leading_zeros()).unwrap_or(0);
            // A pixel starts outside of these, whatever it shows, and each that it lies in flips it back.
            let outside = numbered().flat_map(|(number, volumes)| {
                let around = volumes.iter().filter(|&&volume| self.marks_outside(volume));
                around.map(move |_| number)
            });
            let outside = outside.fold(0, |all, number| all ^ number);
            let marks = numbered()
                .flat_map(|(mask, volumes)| self.mark(volumes, StencilOperation::Invert { mask }));
            passes.push(FillPass::marking(marks.collect()));
            let covers = numbered().map(|(number, volumes)| FillCommand::Cover {
                test: StencilTest {
                    reference: number ^ outside,
                    read_mask: bits,
                    ..StencilTest::ANYWHERE
                },
                shape: CoverShape::Rectangle,
                volumes: volumes.clone(),
            });
            passes.push(FillPass::colouring(covers.collect()));
        }
        passes
    }

    fn bit_planes(&self) -> Vec<FillPass> {
        let mut passes = Vec::new();
        for planes in ordered_batches(self.volumes, usize::from(self.switches.stencil_bits())) {
            let bit = |plane: usize| 1_u8 << plane;
            let marks = planes.iter().enumerate().flat_map(|(plane, volumes)| {
                self.mark(volumes, StencilOperation::Invert { mask: bit(plane) })
            });
            passes.push(FillPass::marking(marks.collect()));
            let mut in_order: Vec<(usize, usize)> = planes
                .iter()
                .enumerate()
                .flat_map(|(plane, volumes)| volumes.iter().map(move |&volume| (volume, plane)))
                .collect();
            in_order.sort_unstable();
            let covers = in_order.iter().map(|&(volume, plane)| FillCommand::Cover {
                test: StencilTest {
                    reference: bit(plane),
                    read_mask: bit(plane),
                    ..StencilTest::ANYWHERE
                },
                shape: CoverShape::Rectangle,
                volumes: vec![volume],
            });
            passes.push(FillPass::colouring(covers.collect()));
        }
        passes
    }

    fn one_at_a_time(&self) -> Vec<FillPass> {
        let mut commands = Vec::new();
        for volume in self.all() {
            commands.extend(self.mark(&[volume], StencilOperation::Count));
            commands.push(FillCommand::Cover {
                test: MARKED,
                shape: match self.switches.colour {
                    ColourWay::Volume => self.cover_shape(volume),
                    _ if self.switches.cover_area == CoverArea::Screen => CoverShape::Screen,
                    _ => CoverShape::Rectangle,
                },
                volumes: vec![volume],
            });
        }
        vec![FillPass {
            clears_stencil: self.switches.stencil_clear == StencilClear::AtStart,
            ..FillPass::colouring(commands)
        }]
    }

    fn id_accumulation(&self) -> Vec<FillPass> {
        let numbers = self.split(&self.all(), |depth, faces, without_bottom, volumes| {
            FillCommand::Accumulate {
                depth,
                faces,
                without_bottom,
                scissor: self.switches.scissor,
                volumes,
            }
        });
        let accumulating = FillPass {
            clears_stencil: false,
            ..FillPass::marking(numbers)
        };
        vec![
            accumulating,
            FillPass::colouring(vec![FillCommand::Resolve]),
        ]
    }

    fn one_colour(&self) -> Vec<FillPass> {
        let zeroes = self.switches.stencil_clear == StencilClear::ByColour;
        let test = StencilTest { zeroes, ..MARKED };
        let covers = match self.switches.colour {
            ColourWay::OneColourVolumes => {
                // Volumes that look alike in one draw; of few kinds, so a list is map enough.
                let mut by_shape: Vec<(CoverShape, Vec<usize>)> = Vec::new();
                for volume in self.all() {
                    let shape = self.cover_shape(volume);
                    match by_shape.iter_mut().find(|(known, _)| *known == shape) {
                        Some((_, volumes)) => volumes.push(volume),
                        None => by_shape.push((shape, vec![volume])),
                    }
                }
                by_shape.sort_by_key(|(shape, _)| *shape);
                let covers = by_shape.into_iter();
                covers
                    .map(|(shape, volumes)| FillCommand::Cover {
                        test,
                        shape,
                        volumes,
                    })
                    .collect()
            }
            _ => vec![FillCommand::Cover {
                test,
                shape: CoverShape::Screen,
                volumes: vec![0],
            }],
        };
        let marking = FillPass {
            clears_stencil: !zeroes,
            first_pass: self.switches.first_pass,
            ..FillPass::marking(self.mark(&self.all(), StencilOperation::Count))
        };
        vec![marking, FillPass::colouring(covers)]
    }
}

/// Any count but 0, taken back to 0 for the next volume.
const MARKED: StencilTest = StencilTest {
    is_equal: false,
    reference: 0,
    read_mask: 0xff,
    zeroes: true,
    skips_sky: false,
};

/// Where there is a surface: one that is made for a view may have none close to the limb.
const ON_GROUND: StencilTest = StencilTest {
    skips_sky: true,
    ..StencilTest::ANYWHERE
};

#[cfg(test)]
mod tests;
