// Sensors: what is read of the motion is not the motion. Each is a record with one function; a new one is a line here.
#pragma once

#include "measurement_noise.hpp"

namespace omnimorph {

/// In the order in which their errors are added.
template <class T> using Sensors = Records<MeasurementNoise<T>>;

/// Pose and rates as they are read: the motion with an error on it, three numbers each for p, v, R and w. The two are
/// kept apart, because the low-pass filters that estimate the motion are taken to follow it without lag.
template <class T> struct Measurement {
    Motion<T> motion;
    Vec<T, 12> error;
    bool has_error;
    std::uint32_t control_step;
};

template <class T> OMNIMORPH_FN bool has_error(const Sensors<T>& sensors) {
    bool any_active = false;
    for_each(sensors, [&](const auto& sensor) { any_active = any_active || sensor.active; });
    return any_active;
}

/// What the sensors read in a control step; the same, however often it is asked for. `first` is the key of lane 0; the
/// lanes are flights that follow one another.
template <class T>
OMNIMORPH_FN Measurement<T> sense(const Sensors<T>& sensors, const Motion<T>& motion, NoiseKey first,
                                  std::uint32_t control_step) {
    Measurement<T> measured;
    measured.motion = motion;
    measured.has_error = has_error(sensors);
    measured.control_step = control_step;
    measured.error = Vec<T, 12>::zero();
    for_each(sensors, [&](const auto& sensor) {
        if (sensor.active) measured.error = measured.error + sensor.error(motion, first, control_step);
    });
    return measured;
}

/// The motion, a little off: by three numbers each in p, v, R exp([n]x) and w.
template <class T> OMNIMORPH_FN Motion<T> with_error(const Motion<T>& motion, const Vec<T, 12>& error) {
    const auto part = [&](int kind) { return Vec3<T>{{error[3 * kind], error[3 * kind + 1], error[3 * kind + 2]}}; };
    return {motion.p + part(0), motion.v + part(1), motion.R * exp_so3(part(2)), motion.w + part(3)};
}

}  // namespace omnimorph
