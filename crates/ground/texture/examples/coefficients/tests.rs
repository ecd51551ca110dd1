// SPDX-License-Identifier: MIT OR Apache-2.0
//! The generator of coefficients against coefficients from two others.
//!
//! Both come from Remez exchanges in Python with 40-digit arithmetic (mpmath) that share nothing with
//! this crate: name, largest error, P's coefficients and, for rationals, Q's, ascending.
//! [`LEVELLED`] was exchanged until the extrema were equal to 22 digits. [`PUBLISHED`] is the table that
//! the design of this crate started from, exchanged until they were equal to six: an error of 1e-6 of
//! its size moves coefficients in their sixth digit.

use crate::remez::{coefficients_source, fit};
use terrafill_texture::AngleCore;

/// The checked-in table.
const TABLE: &str = include_str!("../../src/coefficients.rs");

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

const PUBLISHED: &str = "\
odd-3: 0.004952: 0.97239411746636422, -0.19194795389209926
odd-rel-3: 0.0126871: 0.9873129406689588, -0.21187917036902471
odd-5: 0.000608595: 0.99535795563468158, -0.28869023841382886, 0.079339040692594504
odd-rel-5: 0.00157592: 0.99842408333223402, -0.30103868185138145, 0.08925048397312656
odd-pin-5: 0.00135098: 1.0, -0.30189478356998403, 0.08729294696743234
odd-7: 8.13707e-5: 0.99921381254403788, -0.32117496974775202, 0.14626446432560569, -0.038986514377570634
odd-rel-7: 0.000212152: 0.99978784773460993, -0.32580844895573575, 0.15557875383072975, -0.044326613211753596
odd-pin-7: 0.000150512: 1.0, -0.32570157633231526, 0.1534299503282781, -0.04233021059851453
odd-9: 1.14385e-5: 0.99986632946879237, -0.33030478554297083, 0.1801592947369787, -0.085156350923035967, 0.020845114199138729
odd-rel-9: 2.9966e-5: 0.9999700339688827, -0.33170083990732335, 0.18521567500924072, -0.091926576606805375, 0.023863406199257453
odd-pin-9: 1.89216e-5: 1.0, -0.3315787828753123, 0.18383034849703369, -0.08925303773502919, 0.02239963551075611
odd-11: 1.66236e-6: 0.99997721909848404, -0.33262282818937415, 0.19354037728967828, -0.11642648371419536, 0.05264735237530823, -0.011719135820644708
odd-rel-11: 4.37039e-6: 0.9999956296108478, -0.3329945968609189, 0.19563592437332219, -0.12123906859452153, 0.057477310542363767, -0.013480468169258487
odd-pin-11: 2.54777e-6: 1.0, -0.33294527733913047, 0.19498657512380739, -0.11921577101612423, 0.055063359536572102, -0.012490722907676481
odd-13: 2.4739e-7: 0.99999611155169497, -0.33317368056759962, 0.1980781557538665, -0.13233342112494975, 0.079623672353860218, -0.033604220341913443, 0.0068117931622191544
odd-rel-13: 6.52169e-7: 0.99999934783072535, -0.33326514922341536, 0.19881482480858255, -0.13487191514026965, 0.083871192854573321, -0.037013002561876443, 0.0078633770416790741
odd-pin-13: 3.58591e-7: 1.0, -0.33324998581344991, 0.19856563532259687, -0.13374657435588295, 0.081675884843944936, -0.035059682443928657, 0.0072128858441680238
odd-15: 3.74765e-8: 0.99999933557864231, -0.3332986078382173, 0.19946565641674322, -0.13908629499262226, 0.096421972017785532, -0.055912325115831573, 0.021862956773057349, -0.00405456691865027
odd-rel-15: 9.90094e-8: 0.9999999009906286, -0.33331990748647103, 0.19969723932367316, -0.14019481095121859, 0.09914293296698227, -0.059486399243599053, 0.024252407081147411, -0.0046932770454729189
odd-pin-15: 5.20541e-8: 1.0, -0.33331584033731887, 0.19961367683596122, -0.13968191325509893, 0.097693323488906702, -0.057394362076602817, 0.022753662364108441, -0.0042703836225074348
dense-2: 0.00334772: 1.0546815032576563, -0.26593562082682123
dense-3: 0.00131157: 1.0271346487318445, -0.16625889124458313, -0.076789161907537277
dense-4: 0.000115136: 1.0025035301509533, -0.013679902497650949, -0.34402679384691757, 0.14071646574885922
dense-5: 2.43191e-5: 0.99872455668838681, 0.020835247706918314, -0.44437888233965789, 0.25712165724775443, -0.046880096815368374
dense-6: 6.99771e-6: 0.99957276204518402, 0.0081069713534522041, -0.38306034463369475, 0.12932326245751739, 0.073231917504719764, -0.04178340304203553
dense-7: 4.1692e-7: 0.99998601468615487, 2.6711341174878162e-5, -0.33044969141440839, -0.028115503677946157, 0.31131632482342439, -0.21880456977765963, 0.051439294336512547
dense-8: 2.07208e-7: 1.0000227182992518, -0.00078449585884934049, -0.32408960033465616, -0.052399511437347429, 0.36174579973415907, -0.27701114324926857, 0.086536157828251361, -0.0086215543763977901
rat-0-1: 0.00220835: 0.9869009264138698; 1.0, 0.26010438385407071
rat-rel-0-1: 0.00548074: 0.99451925528193562; 1.0, 0.27323954473516346
rat-1-1: 9.8161e-5: 0.99918033558418983, 0.19114706744458832; 1.0, 0.51538252456675201
rat-rel-1-1: 0.000243084: 0.99975691578619283, 0.20025661331354352; 1.0, 0.52753336022105058
rat-1-2: 4.30928e-6: 0.99995364834190451, 0.42262166544394776; 1.0, 0.75509636388978211, 0.056192719077754857
rat-rel-1-2: 1.06629e-5: 0.99998933706097656, 0.43345027701547017; 1.0, 0.76630788605370319, 0.058823576843837787
rat-2-2: 1.88102e-7: 0.99999752495112741, 0.65590576532993055, 0.040551598981678526; 1.0, 0.98917013352732339, 0.17082280002433048
rat-rel-2-2: 4.65264e-7: 0.99999953473610098, 0.66673640815761429, 0.042435939618786736; 1.0, 1.0000371455002234, 0.17614707156418181
rat-2-3: 8.18547e-9: 0.99999987265151675, 0.88767795037281586, 0.13332061230224464; 1.0, 1.2210063020173744, 0.34037864793777337, 0.011830204568755494
rat-rel-2-3: 2.02422e-8: 0.99999997975790196, 0.89839653010543375, 0.13761289569981871; 1.0, 1.2317278139765626, 0.34822215172506131, 0.012377775388268286
rat-3-3: 3.55541e-10: 0.99999999361565972, 1.1184076328927641, 0.27940889798247989, 0.0085032844992531617; 1.0, 1.4517406324064056, 0.56332747855407201, 0.048753425738394313
rat-rel-3-3: 8.7911e-10: 0.99999999912088988, 1.1290534461636657, 0.28615143632097002, 0.0088959519538108523; 1.0, 1.4623866580223333, 0.57361635974301039, 0.050458021234535145
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
fn the_published_table_agrees_as_far_as_it_is_levelled() {
    let (coefficients, errors) = differences(PUBLISHED);
    // The smallest coefficient of dense-7 differs by 3.9e-6, every other by less than 7e-7.
    assert!(coefficients < 5e-6, "{coefficients:e}");
    // The table gives six digits of each error.
    assert!(errors < 1.2e-5, "{errors:e}");
    // Negative control.
    let mutant = PUBLISHED.replacen("-0.1919479", "-0.1919579", 1);
    assert_ne!(mutant, PUBLISHED);
    assert!(differences(&mutant).0 > 5e-6);
}

#[test]
fn a_list_of_another_length_is_noticed() {
    assert!(difference(&[1.0], &[1.0, 2.0]).is_infinite());
}

/// Largest relative difference between the numbers of two texts; infinite where words differ.
fn text_difference(one: &str, other: &str) -> f64 {
    let words = |text: &str| -> Vec<String> {
        text.split(|c: char| c.is_whitespace() || "[],&".contains(c))
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
    let fresh = coefficients_source().expect("every core has a fit");
    // Sines of the first reference come from the C library, so the last digits may differ.
    let found = text_difference(TABLE, &fresh);
    assert!(
        found < 1e-11,
        "coefficients.rs is not what is generated: {found:e}"
    );
    // Negative controls: a digit of one number, a word, a missing row.
    let mutant = TABLE.replacen("0.999213812", "0.999213813", 1);
    assert_ne!(mutant, TABLE);
    assert!(text_difference(&mutant, &fresh) > 1e-11);
    let renamed = TABLE.replacen("Pinned", "Absolute", 1);
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
