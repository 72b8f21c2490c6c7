// Dead band: a sensorless motor cannot turn slowly, and cannot reverse without stopping first.
#pragma once

#include "actuators.hpp"

namespace omnimorph {

/// A command |w| < w_dead gives the nearer of rest and ±w_dead. A command against the present rotation first brakes the
/// rotor down to w_dead, then holds it at rest for the reversal time. A rotor with w_dead = 0
/// has no dead band.
template <class T, int N> struct DeadBand {
    static constexpr const char* name = "dead-band";
    bool active = false;
    PerRotor<T, N> smallest{};  // w_dead, rad/s
    T reversal_time = T(0);     // s

    static constexpr auto fields() {
        return field_list(derived("active", &DeadBand::active), field("smallest", &DeadBand::smallest),
                          field("reversal_time", &DeadBand::reversal_time));
    }

    /// The speed that the motor driver aims at. `rest_left` (s) is how long the rotor stays at rest once it stops.
    OMNIMORPH_FN T follow(int i, const T& command, Rotor<T> rotor, ActuatorStep step) const {
        const T size = abs(command);
        const T nearer = select(size < T(0.5) * smallest[i], T(0), max(size, smallest[i]));
        const T wanted = with_sign(nearer, command);
        const Mask<T> reversing = (wanted * rotor.speed < T(0)) & (smallest[i] > T(0));
        const Mask<T> stops = reversing & (abs(rotor.speed) <= smallest[i] * T(1 + 1e-9));
        rotor.speed = select(stops, T(0), rotor.speed);
        rotor.rest_left = select(reversing, reversal_time, rotor.rest_left);
        const Mask<T> resting =
            (rotor.speed == T(0)) & (rotor.rest_left > T(1e-9));  // what rounding leaves of a rest is none
        rotor.rest_left = max(rotor.rest_left - T(step.length), T(0));
        return select(reversing | resting, T(0), wanted);
    }
};

}  // namespace omnimorph
