use super::factor;

#[test]
fn a_ratio_of_steps_has_the_bits_of_its_formula() {
    for k in 0..4000 {
        let error = libm::exp(f64::from(k - 3000) * 0.01);
        assert_eq!(factor(error).to_bits(), (0.9 * libm::pow(error, -0.2)).clamp(0.2, 5.0).to_bits(), "{error}");
    }
    let ends = [0.0, f64::INFINITY, f64::NAN].map(|error| factor(error).to_bits());
    assert_eq!(ends, [5.0_f64, 0.2, 0.2].map(f64::to_bits));
}
