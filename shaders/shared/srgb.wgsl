// IEC 61966-2-1: a sampler gives linear light, a target holds what a screen is sent.
//
// Instead of the standard's 1.055 x^(1/2.4) − 0.055 the cubic in y = x^(1/4) that is nearest to it
// between the join and 1: 0.055 levels of 255 off at most. It alternates there five times between
// that error and its opposite, by which a test knows it (Chebyshev), and two square roots cost less
// than a power.
fn srgb_of_linear(linear: vec3<f32>) -> vec3<f32> {
    let y = sqrt(sqrt(linear));
    let curved = ((-0.13682347 * y + 0.9525713) * y + 0.25579907) * y - 0.07176167;
    return select(curved, linear * 12.92, linear <= vec3<f32>(0.0031308));
}
