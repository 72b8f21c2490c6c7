// A sensorless motor cannot turn slowly, and cannot turn round without stopping first.
#pragma once

#include "../model/vehicle.hpp"

namespace omnimorph {

/// A command |w| < w_dead gives the nearer of rest and ±w_dead. A command against the present rotation first brakes the
/// rotor down to w_dead, then holds it at rest for the reversal time. Nothing of this holds for a rotor with w_dead = 0.
template <class T, int N> struct DeadBand {
    bool active = false;
    PerRotor<T, N> smallest{};  // w_dead, rad/s
    T reversal_time{};          // s

    DeadBand() = default;
    template <class S, int M> DeadBand(const DeadBand<S, M>& o, int n)
        : active(o.active), smallest(cast<T, N>(o.smallest, n)), reversal_time(T(o.reversal_time)) {}

    /// What the motor driver really aims at. `rest_left` (s) is how long the rotor will have to stay at rest once it stops.
    T aim(int i, const T& command, T& speed, T& rest_left, const T& step) const {
        if (!active) return command;
        const T size = abs(command);
        const T nearer = select(size < T(0.5) * smallest[i], T(0), max(size, smallest[i]));
        const T wanted = with_sign(nearer, command);
        const Mask<T> reversing = (wanted * speed < T(0)) & (smallest[i] > T(0));
        const Mask<T> stops = reversing & (abs(speed) <= smallest[i] * T(1 + 1e-9));
        speed = select(stops, T(0), speed);
        rest_left = select(reversing, reversal_time, rest_left);
        const Mask<T> resting = (speed == T(0)) & (rest_left > T(1e-9));  // what rounding leaves of a rest is none
        rest_left = max(rest_left - step, T(0));
        return select(reversing | resting, T(0), wanted);
    }
};

}  // namespace omnimorph
