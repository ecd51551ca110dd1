// SPDX-License-Identifier: MIT OR Apache-2.0
//! Minimax coefficients of the arctangent on [0, 1], by family.
//!
//! Written by `cargo run -p terrafill-texture --example coefficients`; the tests of that example
//! compare. No coefficient is written anywhere else.

use crate::angle_core::{AngleCore, Weight};

/// One core's coefficients, ascending powers.
pub(crate) struct Coefficients {
    pub(crate) core: AngleCore,
    /// Largest error in exact arithmetic: radians, or relative where the weight is.
    pub(crate) error: f64,
    pub(crate) numerator: &'static [f64],
    /// Empty for polynomials.
    pub(crate) denominator: &'static [f64],
}

/// Every core that has coefficients.
#[rustfmt::skip]
pub(crate) const COEFFICIENTS: &[Coefficients] = &[
    Coefficients {
        core: AngleCore::Odd { degree: 3, weight: Weight::Absolute },
        error: 4.951999971119639e-3,
        numerator: &[0.9723941179626872, -0.19194795453635746],
        denominator: &[],
    },
    Coefficients {
        core: AngleCore::Odd { degree: 3, weight: Weight::Relative },
        error: 1.268705934746161e-2,
        numerator: &[0.9873129406525384, -0.21187917036550086],
        denominator: &[],
    },
    Coefficients {
        core: AngleCore::Odd { degree: 5, weight: Weight::Absolute },
        error: 6.085947651444328e-4,
        numerator: &[0.9953579547605107, -0.288690238085004, 0.07933904148708597],
        denominator: &[],
    },
    Coefficients {
        core: AngleCore::Odd { degree: 5, weight: Weight::Relative },
        error: 1.5759169614222366e-3,
        numerator: &[0.9984240830385781, -0.30103867973020026, 0.0892504823762382],
        denominator: &[],
    },
    Coefficients {
        core: AngleCore::Odd { degree: 5, weight: Weight::Pinned },
        error: 1.350983224737243e-3,
        numerator: &[1.0, -0.30189478312144963, 0.08729294651889792],
        denominator: &[],
    },
    Coefficients {
        core: AngleCore::Odd { degree: 7, weight: Weight::Absolute },
        error: 8.137070647326687e-5,
        numerator: &[0.999213812572609, -0.32117496933179573, 0.14626446364537304, -0.03898651419521128],
        denominator: &[],
    },
    Coefficients {
        core: AngleCore::Odd { degree: 7, weight: Weight::Relative },
        error: 2.1215244983899652e-4,
        numerator: &[0.9997878475501611, -0.3258084480573144, 0.15557875352400816, -0.04432661376387027],
        denominator: &[],
    },
    Coefficients {
        core: AngleCore::Odd { degree: 7, weight: Weight::Pinned },
        error: 1.505122721551484e-4,
        numerator: &[1.0, -0.3257015759935656, 0.15342994884206798, -0.04233020945105408],
        denominator: &[],
    },
    Coefficients {
        core: AngleCore::Odd { degree: 9, weight: Weight::Absolute },
        error: 1.1438541865651558e-5,
        numerator: &[0.9998663294659202, -0.33030478550486475, 0.18015929463653335, -0.0851563508337138, 0.020845114175438904],
        denominator: &[],
    },
    Coefficients {
        core: AngleCore::Odd { degree: 9, weight: Weight::Relative },
        error: 2.996605946121723e-5,
        numerator: &[0.9999700339405387, -0.33170084008138284, 0.1852156763363269, -0.09192657907184475, 0.023863407561875303],
        denominator: &[],
    },
    Coefficients {
        core: AngleCore::Odd { degree: 9, weight: Weight::Pinned },
        error: 1.892159862460329e-5,
        numerator: &[1.0, -0.33157878236439553, 0.1838303473801788, -0.0892530375872409, 0.022399635968905946],
        denominator: &[],
    },
    Coefficients {
        core: AngleCore::Odd { degree: 11, weight: Weight::Absolute },
        error: 1.6623600625050628e-6,
        numerator: &[0.9999772190799163, -0.3326228278407496, 0.1935403757729598, -0.11642648118471723, 0.0526473506160219, -0.011719135406045413],
        denominator: &[],
    },
    Coefficients {
        core: AngleCore::Odd { degree: 11, weight: Weight::Relative },
        error: 4.37039509999667e-6,
        numerator: &[0.9999956296049, -0.3329945968400945, 0.19563592477347835, -0.12123907066989699, 0.05747731364321287, -0.01348046961443626],
        denominator: &[],
    },
    Coefficients {
        core: AngleCore::Odd { degree: 11, weight: Weight::Pinned },
        error: 2.5477724974508566e-6,
        numerator: &[1.0, -0.33294527685374076, 0.19498657165383668, -0.11921576270474077, 0.055063351366965906, -0.012490720064872748],
        denominator: &[],
    },
    Coefficients {
        core: AngleCore::Odd { degree: 13, weight: Weight::Absolute },
        error: 2.4739028066356355e-7,
        numerator: &[0.9999961115491404, -0.33317368053225793, 0.1980781555101366, -0.1323334204208337, 0.0796236713855215, -0.033604219713957585, 0.006811793009979763],
        denominator: &[],
    },
    Coefficients {
        core: AngleCore::Odd { degree: 13, weight: Weight::Relative },
        error: 6.521703912172005e-7,
        numerator: &[0.9999993478296088, -0.3332651492027656, 0.1988148246277855, -0.1348719145322889, 0.08387119202973728, -0.03701300214812019, 0.007863377006918918],
        denominator: &[],
    },
    Coefficients {
        core: AngleCore::Odd { degree: 13, weight: Weight::Pinned },
        error: 3.5859104690225777e-7,
        numerator: &[1.0, -0.33324998579202075, 0.1985656350571448, -0.13374657325438513, 0.0816758828597764, -0.03505968083634027, 0.007212885363273274],
        denominator: &[],
    },
    Coefficients {
        core: AngleCore::Odd { degree: 15, weight: Weight::Absolute },
        error: 3.7476591087659556e-8,
        numerator: &[0.9999993355783389, -0.33329860784327336, 0.1994656565124409, -0.13908629549687548, 0.09642197327301283, -0.055912326759431884, 0.021862957868206963, -0.004054567211561558],
        denominator: &[],
    },
    Coefficients {
        core: AngleCore::Odd { degree: 15, weight: Weight::Relative },
        error: 9.900965955116538e-8,
        numerator: &[0.9999999009903404, -0.3333199074652254, 0.19969723901017136, -0.14019480927611822, 0.09914292871364436, -0.05948639366634025, 0.024252403429362097, -0.0046932761003908845],
        denominator: &[],
    },
    Coefficients {
        core: AngleCore::Odd { degree: 15, weight: Weight::Pinned },
        error: 5.2054166983362553e-8,
        numerator: &[1.0, -0.3333158403395014, 0.1996136769342104, -0.13968191392603702, 0.09769332542847045, -0.057394364916547654, 0.02275366443999826, -0.004270384223144742],
        denominator: &[],
    },
    Coefficients {
        core: AngleCore::Dense { degree: 2 },
        error: 3.3477199037523974e-3,
        numerator: &[1.054681507346537, -0.26593562404533627],
        denominator: &[],
    },
    Coefficients {
        core: AngleCore::Dense { degree: 3 },
        error: 1.3115684534646165e-3,
        numerator: &[1.0271346523963085, -0.16625890214757938, -0.0767891553047454],
        denominator: &[],
    },
    Coefficients {
        core: AngleCore::Dense { degree: 4 },
        error: 1.1513617665214211e-4,
        numerator: &[1.0025035299984577, -0.01367990181730177, -0.3440267952255744, 0.140716466618519],
        denominator: &[],
    },
    Coefficients {
        core: AngleCore::Dense { degree: 5 },
        error: 2.431912434409141e-5,
        numerator: &[0.9987245574578651, 0.020835242035332484, -0.44437886683563277, 0.2571216393846385, -0.046880089520410964],
        denominator: &[],
    },
    Coefficients {
        core: AngleCore::Dense { degree: 6 },
        error: 6.997717243224788e-6,
        numerator: &[0.9995727618346364, 0.008106974499536535, -0.3830603596734207, 0.12932329368199888, 0.07323188825601405, -0.04178339291856006],
        denominator: &[],
    },
    Coefficients {
        core: AngleCore::Dense { degree: 7 },
        error: 4.169205401195613e-7,
        numerator: &[0.9999860146901772, 2.671123596073413e-5, -0.3304496901972174, -0.028115508629229565, 0.31131633372468126, -0.2188045771285979, 0.051439296622214074],
        denominator: &[],
    },
    Coefficients {
        core: AngleCore::Dense { degree: 8 },
        error: 2.0720811979836584e-7,
        numerator: &[1.0000227183165242, -0.0007844959608556104, -0.32408960098843, -0.05239950477297832, 0.3617457791934339, -0.2770111134435371, 0.08653613690446543, -0.008621548643054323],
        denominator: &[],
    },
    Coefficients {
        core: AngleCore::Rational { numerator: 0, denominator: 1, weight: Weight::Absolute },
        error: 2.208348055776513e-3,
        numerator: &[0.9869009156995705],
        denominator: &[1.0, 0.2601043787437766],
    },
    Coefficients {
        core: AngleCore::Rational { numerator: 0, denominator: 1, weight: Weight::Relative },
        error: 5.480746516117944e-3,
        numerator: &[0.994519253483882],
        denominator: &[1.0, 0.2732395447351627],
    },
    Coefficients {
        core: AngleCore::Rational { numerator: 1, denominator: 1, weight: Weight::Absolute },
        error: 9.816100748927443e-5,
        numerator: &[0.9991803357044761, 0.1911470709117637],
        denominator: &[1.0, 0.5153825290245463],
    },
    Coefficients {
        core: AngleCore::Rational { numerator: 1, denominator: 1, weight: Weight::Relative },
        error: 2.430842697315158e-4,
        numerator: &[0.9997569157302685, 0.20025661483872034],
        denominator: &[1.0, 0.5275333620059008],
    },
    Coefficients {
        core: AngleCore::Rational { numerator: 1, denominator: 2, weight: Weight::Absolute },
        error: 4.309285414810132e-6,
        numerator: &[0.9999536483341629, 0.4226216611886818],
        denominator: &[1.0, 0.7550963595145348, 0.05619271802887003],
    },
    Coefficients {
        core: AngleCore::Rational { numerator: 1, denominator: 2, weight: Weight::Relative },
        error: 1.0662939795120206e-5,
        numerator: &[0.9999893370602049, 0.43345027757728366],
        denominator: &[1.0, 0.7663078866215824, 0.05882357699171517],
    },
    Coefficients {
        core: AngleCore::Rational { numerator: 2, denominator: 2, weight: Weight::Absolute },
        error: 1.8810263509004315e-7,
        numerator: &[0.9999975249493185, 0.6559057499999675, 0.040551596320868306],
        denominator: &[1.0, 0.9891701181530237, 0.1708227924890535],
    },
    Coefficients {
        core: AngleCore::Rational { numerator: 2, denominator: 2, weight: Weight::Relative },
        error: 4.652645150442547e-7,
        numerator: &[0.999999534735485, 0.6667364105818246, 0.04243594020333992],
        denominator: &[1.0, 1.0000371479151817, 0.1761470729779734],
    },
    Coefficients {
        core: AngleCore::Rational { numerator: 2, denominator: 3, weight: Weight::Absolute },
        error: 8.185505658717258e-9,
        numerator: &[0.9999998726513434, 0.8876779505789191, 0.13332061256692646],
        denominator: &[1.0, 1.2210063022211919, 0.34037864828131287, 0.01183020462071407],
    },
    Coefficients {
        core: AngleCore::Rational { numerator: 2, denominator: 3, weight: Weight::Relative },
        error: 2.0242171210242553e-8,
        numerator: &[0.9999999797578288, 0.8983965003890995, 0.13761288345807526],
        denominator: &[1.0, 1.2317277842564662, 0.34822212961780935, 0.012377773793028296],
    },
    Coefficients {
        core: AngleCore::Rational { numerator: 3, denominator: 3, weight: Weight::Absolute },
        error: 3.555419888449473e-10,
        numerator: &[0.9999999936156633, 1.11840763783454, 0.27940890123830825, 0.008503284701295275],
        denominator: &[1.0, 1.4517406373482056, 0.5633274834570009, 0.0487534265884291],
    },
    Coefficients {
        core: AngleCore::Rational { numerator: 3, denominator: 3, weight: Weight::Relative },
        error: 8.791129245495057e-10,
        numerator: &[0.9999999991208871, 1.129053454085936, 0.286151441784264, 0.008895952318334914],
        denominator: &[1.0, 1.4623866659444062, 0.5736163678482874, 0.050458022714329136],
    },
];
