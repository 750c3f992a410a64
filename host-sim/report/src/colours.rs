//! The colours of series: each can be seen on its panel, and any two can be told apart with each kind of colour vision.
//!
//! Colour blindness is simulated by the matrices of G. M. Machado, M. M. Oliveira, L. A. F. Fernandes (A physiologically-based model for simulation
//! of color vision deficiency, 2009), at full severity. Differences are Euclidean distances in CIELAB (1976).
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

type Matrix = [[f64; 3]; 3];

const SIGHT: [(&str, Matrix); 4] = [
    ("normal", [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
    (
        "protanopia",
        [[0.152_286, 1.052_583, -0.204_868], [0.114_503, 0.786_281, 0.099_216], [-0.003_882, -0.048_116, 1.051_998]],
    ),
    (
        "deuteranopia",
        [[0.367_322, 0.860_646, -0.227_968], [0.280_085, 0.672_501, 0.047_413], [-0.011_820, 0.042_940, 0.968_881]],
    ),
    (
        "tritanopia",
        [[1.255_528, -0.076_749, -0.178_779], [-0.078_411, 0.930_809, 0.147_602], [0.004_733, 0.691_367, 0.303_900]],
    ),
];

/// Linear red, green and blue of `#rrggbb`.
fn linear(hex: &str) -> [f64; 3] {
    [1, 3, 5].map(|at| {
        let x = f64::from(u8::from_str_radix(&hex[at..at + 2], 16).unwrap()) / 255.0;
        if x <= 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
    })
}

fn product(rows: &Matrix, x: [f64; 3]) -> [f64; 3] {
    rows.map(|row| row[0] * x[0] + row[1] * x[1] + row[2] * x[2])
}

fn lab(rgb: [f64; 3]) -> [f64; 3] {
    const XYZ: Matrix = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]];
    let [x, y, z] = product(&XYZ, rgb);
    let f = |t: f64| if t > 0.008_856 { t.cbrt() } else { 7.787 * t + 16.0 / 116.0 };
    let (x, y, z) = (f(x / 0.950_47), f(y), f(z / 1.088_83));
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

fn luminance(hex: &str) -> f64 {
    let [r, g, b] = linear(hex);
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// Contrast by WCAG 2.
fn contrast(a: &str, b: &str) -> f64 {
    let (a, b) = (luminance(a), luminance(b));
    (a.max(b) + 0.05) / (a.min(b) + 0.05)
}

/// Smallest difference between two of these colours as this sight sees them, and their places.
fn closest(colours: &[&str], sight: &Matrix) -> (f64, usize, usize) {
    let seen: Vec<[f64; 3]> =
        colours.iter().map(|hex| lab(product(sight, linear(hex)).map(|x| x.clamp(0.0, 1.0)))).collect();
    let distance = |a: &[f64; 3], b: &[f64; 3]| (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt();
    let pairs = (0..seen.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    pairs.map(|(i, j)| (distance(&seen[i], &seen[j]), j, i)).min_by(|a, b| a.0.total_cmp(&b.0)).unwrap()
}

/// Value of a variable of the style sheet in its light, dark or printed block.
fn variable(block: usize, name: &str) -> &'static str {
    let css = include_str!("../assets/report.css");
    let block = css.split(":root {").nth(block + 1).unwrap();
    block.split(&format!("{name}: ")).nth(1).unwrap().split(';').next().unwrap()
}

#[test]
fn every_two_colours_of_series_differ_in_every_sight() {
    for (block, ground) in [(0, "#ffffff"), (1, variable(1, "--panel")), (2, "#ffffff")] {
        let names = ["--c0", "--c1", "--c2", "--c3", "--c4", "--c5"];
        let colours = names.map(|name| variable(block, name));
        for colour in colours {
            assert!(contrast(colour, ground) >= 3.0, "{colour} on {ground}: {}", contrast(colour, ground));
        }
        for (sight, matrix) in &SIGHT {
            let (distance, i, j) = closest(&colours, matrix);
            assert!(distance >= 15.0, "{sight}: {} and {} differ by {distance:.1}", colours[i], colours[j]);
        }
    }
}

#[test]
fn red_and_green_of_one_lightness_are_found() {
    assert!(closest(&["#1f5fa8", "#6a4bb5"], &SIGHT[2].1).0 < 10.0);
    assert!(closest(&["#1f5fa8", "#6a4bb5"], &SIGHT[0].1).0 > 30.0);
    assert!((contrast("#000000", "#ffffff") - 21.0).abs() < 1e-9);
}
