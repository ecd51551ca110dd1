// SPDX-License-Identifier: MIT OR Apache-2.0
//! The generator of coefficients against those of another.
//!
//! They come from Remez exchanges in Python with 40-digit arithmetic (mpmath) that share nothing with
//! this crate: name, largest error, P's coefficients and, for rationals, Q's, ascending. [`LEVELLED`] was
//! exchanged until the extrema were equal to 22 digits.

use crate::remez::{coefficients_table, fit};
use terrafill_texture::AngleCore;

/// The checked-in table.
const TABLE: &str = include_str!("../../src/coefficients.csv");

const LEVELLED: &str = "\
odd-3: 0.00495199997112: 0.97239411796268611, -0.19194795453635687
odd-rel-3: 0.0126870593475: 0.98731294065253839, -0.21187917036550086
odd-5: 0.000608594765144: 0.99535795476051075, -0.28869023808500398, 0.079339041487085972
odd-rel-5: 0.00157591696142: 0.99842408303857795, -0.30103867973020068, 0.089250482376238809
odd-pin-5: 0.00135098322474: 1.0, -0.30189478312144962, 0.087292946518897927
odd-7: 8.13707064733e-5: 0.99921381257260901, -0.32117496933179572, 0.14626446364537304, -0.038986514195211278
odd-rel-7: 0.000212152449839: 0.99978784755016108, -0.32580844805731409, 0.15557875352400798, -0.044326613763870414
odd-pin-7: 0.000150512272155: 1.0, -0.32570157599356558, 0.15342994884206797, -0.042330209451054079
odd-9: 1.14385418657e-5: 0.99986632946592026, -0.33030478550486476, 0.18015929463653335, -0.0851563508337138, 0.020845114175438905
odd-rel-9: 2.99660594612e-5: 0.99997003394053878, -0.33170084008138284, 0.18521567633632691, -0.091926579071844748, 0.023863407561875302
odd-pin-9: 1.89215986246e-5: 1.0, -0.33157878236439553, 0.18383034738017881, -0.089253037587240909, 0.022399635968905945
odd-11: 1.66236006251e-6: 0.99997721907991632, -0.33262282784074958, 0.19354037577295981, -0.11642648118471723, 0.0526473506160219, -0.011719135406045414
odd-rel-11: 4.3703951e-6: 0.9999956296049, -0.33299459684009452, 0.19563592477347835, -0.12123907066989699, 0.057477313643212866, -0.013480469614436261
odd-pin-11: 2.54777249745e-6: 1.0, -0.33294527685374074, 0.19498657165383667, -0.11921576270474077, 0.055063351366965904, -0.012490720064872749
odd-13: 2.47390280664e-7: 0.99999611154914034, -0.33317368053225794, 0.19807815551013661, -0.13233342042083372, 0.079623671385521491, -0.033604219713957583, 0.0068117930099797628
odd-rel-13: 6.52170391217e-7: 0.99999934782960878, -0.33326514920276561, 0.1988148246277855, -0.13487191453228888, 0.083871192029737279, -0.037013002148120193, 0.0078633770069189183
odd-pin-13: 3.58591046902e-7: 1.0, -0.33324998579202075, 0.19856563505714479, -0.13374657325438513, 0.081675882859776393, -0.035059680836340273, 0.0072128853632732734
odd-15: 3.74765910877e-8: 0.99999933557833883, -0.33329860784327337, 0.19946565651244088, -0.13908629549687547, 0.096421973273012826, -0.055912326759431883, 0.021862957868206964, -0.0040545672115615573
odd-rel-15: 9.90096595512e-8: 0.99999990099034045, -0.33331990746522537, 0.19969723901017137, -0.14019480927611822, 0.09914292871364435, -0.059486393666340252, 0.024252403429362095, -0.0046932761003908843
odd-pin-15: 5.20541669834e-8: 1.0, -0.3333158403395014, 0.1996136769342104, -0.13968191392603699, 0.097693325428470426, -0.057394364916547631, 0.022753664439998245, -0.0042703842231447375
dense-2: 0.00334771990375: 1.054681507346537, -0.26593562404533624
dense-3: 0.00131156845346: 1.0271346523963085, -0.16625890214757938, -0.07678915530474539
dense-4: 0.000115136176652: 1.0025035299984576, -0.013679901817301768, -0.3440267952255744, 0.140716466618519
dense-5: 2.43191243441e-5: 0.99872455745786515, 0.020835242035332484, -0.44437886683563276, 0.25712163938463847, -0.046880089520410939
dense-6: 6.99771724322e-6: 0.99957276183463643, 0.0081069744995365343, -0.38306035967342075, 0.12932329368199887, 0.073231888256014052, -0.04178339291856006
dense-7: 4.16920540119e-7: 0.99998601469017726, 2.6711235960806692e-5, -0.33044969019721783, -0.028115508629228563, 0.31131633372467997, -0.2188045771285971, 0.051439296622213881
dense-8: 2.07208119798e-7: 1.0000227183165241, -0.00078449596085561069, -0.32408960098842997, -0.052399504772978319, 0.36174577919343391, -0.27701111344353713, 0.08653613690446543, -0.0086215486430543224
rat-0-1: 0.00220834805578: 0.98690091569957046; 1.0, 0.26010437874377661
rat-rel-0-1: 0.00548074651612: 0.99451925348388206; 1.0, 0.27323954473516269
rat-1-1: 9.81610074893e-5: 0.99918033570447608, 0.19114707091176369; 1.0, 0.51538252902454631
rat-rel-1-1: 0.000243084269732: 0.99975691573026848, 0.20025661483872034; 1.0, 0.52753336200590083
rat-1-2: 4.30928541481e-6: 0.99995364833416284, 0.42262166118868177; 1.0, 0.75509635951453479, 0.056192718028870027
rat-rel-1-2: 1.06629397951e-5: 0.99998933706020488, 0.43345027757728367; 1.0, 0.76630788662158248, 0.05882357699171517
rat-2-2: 1.8810263509e-7: 0.99999752494931854, 0.65590574999996757, 0.04055159632086831; 1.0, 0.98917011815302375, 0.1708227924890535
rat-rel-2-2: 4.65264515044e-7: 0.99999953473548496, 0.66673641058182474, 0.042435940203339938; 1.0, 1.0000371479151819, 0.17614707297797347
rat-2-3: 8.18550565872e-9: 0.99999987265134335, 0.88767795057891937, 0.13332061256692655; 1.0, 1.2210063022211921, 0.34037864828131307, 0.011830204620714084
rat-rel-2-3: 2.02421712102e-8: 0.99999997975782879, 0.89839650038909947, 0.13761288345807528; 1.0, 1.2317277842564663, 0.34822212961780935, 0.012377773793028295
rat-3-3: 3.55541988845e-10: 0.99999999361566327, 1.1184076378345399, 0.27940890123830823, 0.0085032847012952756; 1.0, 1.4517406373482056, 0.56332748345700087, 0.048753426588429097
rat-rel-3-3: 8.7911292455e-10: 0.99999999912088708, 1.129053454085936, 0.286151441784264, 0.008895952318334914; 1.0, 1.4623866659444062, 0.5736163678482874, 0.050458022714329138
";

struct Row {
    core: AngleCore,
    error: f64,
    numerator: Vec<f64>,
    denominator: Vec<f64>,
}

fn rows(table: &str) -> Vec<Row> {
    let numbers = |list: &str| -> Vec<f64> {
        let number = |text: &str| text.trim().parse().expect("a number");
        list.split(',').map(number).collect()
    };
    table
        .lines()
        .map(|line| {
            let fields: Vec<&str> = line.split(':').collect();
            let [name, error, lists] = fields[..] else {
                panic!("{line}: three fields");
            };
            let core = AngleCore::all()
                .into_iter()
                .find(|core| core.name() == name)
                .unwrap_or_else(|| panic!("{name}: no such core"));
            let (numerator, denominator) = match lists.split_once(';') {
                Some((numerator, denominator)) => (numbers(numerator), numbers(denominator)),
                None => (numbers(lists), Vec::new()),
            };
            Row {
                core,
                error: error.trim().parse().expect("a number"),
                numerator,
                denominator,
            }
        })
        .collect()
}

/// Largest relative difference between two lists; infinite if one is longer.
fn difference(ours: &[f64], theirs: &[f64]) -> f64 {
    if ours.len() != theirs.len() {
        return f64::INFINITY;
    }
    ours.iter()
        .zip(theirs)
        .map(|(a, b)| (a / b - 1.0).abs())
        .fold(0.0, f64::max)
}

/// Largest relative differences between the table in use and another: coefficients, largest errors.
fn differences(table: &str) -> (f64, f64) {
    let rows = rows(table);
    let with_coefficients = AngleCore::all()
        .into_iter()
        .filter(|core| core.coefficients().is_some())
        // Another project's: rounded, and held to its shape where it stands.
        .filter(|core| *core != AngleCore::CesiumCubic)
        .count();
    assert_eq!(rows.len(), with_coefficients, "each core has its row");
    let (mut coefficients, mut errors) = (0.0_f64, 0.0_f64);
    for row in rows {
        let (numerator, denominator) = row.core.coefficients().expect("in the table");
        coefficients = coefficients
            .max(difference(numerator, &row.numerator))
            .max(difference(denominator, &row.denominator));
        let error = row.core.theory_error().expect("in the table");
        errors = errors.max((error / row.error - 1.0).abs());
    }
    (coefficients, errors)
}

#[test]
fn every_coefficient_agrees_to_eleven_digits() {
    let (coefficients, errors) = differences(LEVELLED);
    assert!(coefficients < 5e-12, "{coefficients:e}");
    assert!(errors < 5e-12, "{errors:e}");
    // Negative control: the ninth digit of one coefficient.
    let mutant = LEVELLED.replacen("-0.19194795", "-0.19194796", 1);
    assert_ne!(mutant, LEVELLED);
    assert!(differences(&mutant).0 > 1e-8);
}

#[test]
fn a_list_of_another_length_is_noticed() {
    assert!(difference(&[1.0], &[1.0, 2.0]).is_infinite());
}

/// Largest relative difference between the numbers of two texts; infinite where words differ.
fn text_difference(one: &str, other: &str) -> f64 {
    let words = |text: &str| -> Vec<String> {
        text.split(|c: char| c.is_whitespace() || c == ',')
            .filter(|word| !word.is_empty())
            .map(str::to_owned)
            .collect()
    };
    let (one, other) = (words(one), words(other));
    if one.len() != other.len() {
        return f64::INFINITY;
    }
    let pair = |(a, b): (&String, &String)| match (a.parse::<f64>(), b.parse::<f64>()) {
        (Ok(a), Ok(b)) => (a / b - 1.0).abs(),
        _ if a == b => 0.0,
        _ => f64::INFINITY,
    };
    one.iter().zip(&other).map(pair).fold(0.0, f64::max)
}

#[test]
fn the_table_is_what_the_generator_writes() {
    let fresh = coefficients_table().expect("every core has a fit");
    // Sines of the first reference come from the C library, so the last digits may differ.
    let found = text_difference(TABLE, &fresh);
    assert!(
        found < 1e-11,
        "coefficients.csv is not what is generated: {found:e}"
    );
    // Negative controls: a digit of one number, a word, a missing row.
    let mutant = TABLE.replacen("0.999213812", "0.999213813", 1);
    assert_ne!(mutant, TABLE);
    assert!(text_difference(&mutant, &fresh) > 1e-11);
    let renamed = TABLE.replacen("pin", "rel", 1);
    assert!(text_difference(&renamed, &fresh) > 1e-11);
    let shorter = TABLE.replacen("0.999213812", "", 1);
    assert!(text_difference(&shorter, &fresh) > 1e-11);
}

#[test]
fn the_error_is_level_and_no_larger_anywhere() {
    // De la Vallée Poussin: with one alternation more than coefficients, no approximation of the
    // family is better than the smallest of those extrema.
    for name in [
        "odd-7",
        "odd-rel-9",
        "odd-pin-11",
        "dense-5",
        "rat-2-2",
        "rat-rel-1-2",
    ] {
        let core = AngleCore::all()
            .into_iter()
            .find(|core| core.name() == name)
            .expect("a core");
        let fitted = fit(core).expect("a fit");
        let relative = name.contains("rel");
        let evaluate = |x: f64, numerator: &[f64]| {
            let u = if name.starts_with("dense") { x } else { x * x };
            let horner = |list: &[f64]| list.iter().rev().fold(0.0, |sum, c| sum * u + c);
            let bottom = if fitted.denominator.is_empty() {
                1.0
            } else {
                horner(&fitted.denominator)
            };
            let error = x.atan() - x * horner(numerator) / bottom;
            if relative { error / x.atan() } else { error }
        };
        let grid = || (1..=20_000).map(|i| f64::from(i) / 20_000.0);
        let largest = |numerator: &[f64]| {
            grid()
                .map(|x| evaluate(x, numerator).abs())
                .fold(0.0, f64::max)
        };
        let most = largest(&fitted.numerator);
        assert!((most / fitted.error - 1.0).abs() < 1e-5, "{name}: {most:e}");
        let signs: Vec<f64> = fitted
            .reference
            .iter()
            .filter(|x| **x > 0.0)
            .map(|x| evaluate(*x, &fitted.numerator))
            .collect();
        assert!(
            signs.windows(2).all(|pair| pair[0] * pair[1] < 0.0),
            "{name}"
        );
        for error in signs {
            assert!((error.abs() / fitted.error - 1.0).abs() < 1e-5, "{name}");
        }
        // Negative control: any change of a coefficient makes it worse.
        for factor in [1.0 - 1e-3, 1.0 + 1e-3] {
            let mut mutant = fitted.numerator.clone();
            mutant[1] *= factor;
            assert!(largest(&mutant) > 1.001 * fitted.error, "{name}");
        }
    }
}

#[test]
fn what_has_no_coefficients_is_refused() {
    let error = fit(AngleCore::Native).expect_err("nothing to fit");
    assert_eq!(error.to_string(), "atan2-native has no coefficients");
}
