// The reference: minimum-jerk segments on position and attitude, evaluated on the fly, or samples of any
// reference.
#pragma once

#include "../math/so3.hpp"
#include "../model/motion.hpp"

namespace omnimorph {

/// From rest to rest: p = p0 + dp s(u), R = exp(angle s(u) [axis_W]x) R0, u = (t - start) / duration.
struct Segment {
    double start, duration;
    Vec3<double> p0, dp;
    Mat3<double> R0;
    Vec3<double> axis_W;
    double angle;
};

/// s = 10 u³ - 15 u⁴ + 6 u⁵ and its first two derivatives in u: the rest-to-rest polynomial of least jerk.
struct MinimumJerk {
    double s, ds, dds;
    OMNIMORPH_FN explicit MinimumJerk(double u)
        : s(u * u * u * (10 + u * (-15 + 6 * u))),
          ds(30 * u * u * (1 - u) * (1 - u)),
          dds(60 * u * (1 - u) * (1 - 2 * u)) {}
};

OMNIMORPH_FN Desired<double> evaluate(const Segment& segment, double time) {
    const double rate = 1.0 / segment.duration;
    double u = (time - segment.start) * rate;
    u = u < 0 ? 0 : (u > 1 ? 1 : u);
    const MinimumJerk profile(u);
    Desired<double> d;
    d.p = segment.p0 + profile.s * segment.dp;
    const double ds = profile.ds * rate, dds = profile.dds * rate * rate;
    d.v = ds * segment.dp;
    d.a = dds * segment.dp;
    if (segment.angle == 0) {
        d.R = segment.R0;
        d.w = d.dw = Vec3<double>::zero();
        return d;
    }
    d.R = exp_so3((segment.angle * profile.s) * segment.axis_W) * segment.R0;
    const Vec3<double> axis_B = transpose_times(segment.R0, segment.axis_W);  // the rotation leaves its own axis alone
    d.w = (segment.angle * ds) * axis_B;
    d.dw = (segment.angle * dds) * axis_B;
    return d;
}

template <class T> OMNIMORPH_FN Desired<T> cast(const Desired<double>& d) {
    return {cast<T>(d.p), cast<T>(d.v), cast<T>(d.R), cast<T>(d.w), cast<T>(d.a), cast<T>(d.dw)};
}

/// A reference for one flight, a view of tables owned elsewhere. Segments hold still before the first and after the
/// last; samples are one row of p, R, v, w, a, dw (24 numbers) for each physics step, and count instead if there are
/// any.
struct Reference {
    const Segment* segments = nullptr;
    long n_segments = 0;
    const double* samples = nullptr;
    long n_samples = 0;
};

/// The sample of a step; the last one, after the last.
OMNIMORPH_FN Desired<double> sample_of(const Reference& reference, long step) {
    const double* row = reference.samples + 24 * (step < reference.n_samples ? step : reference.n_samples - 1);
    Desired<double> d;
    for (int c = 0; c < 3; ++c) {
        d.p[c] = row[c];
        for (int k = 0; k < 3; ++k) d.R[c][k] = row[3 + 3 * c + k];
        d.v[c] = row[12 + c];
        d.w[c] = row[15 + c];
        d.a[c] = row[18 + c];
        d.dw[c] = row[21 + c];
    }
    return d;
}

/// The desired motion in a physics step, which begins at `time`, s.
OMNIMORPH_FN Desired<double> desired_at(const Reference& reference, long step, double time) {
    if (reference.n_samples > 0) return sample_of(reference, step);
    long i = 0;
    while (i + 1 < reference.n_segments && time >= reference.segments[i + 1].start) ++i;
    return evaluate(reference.segments[i], time);
}

}  // namespace omnimorph
