// Rotors take time to change speed.
#pragma once

#include "../model/vehicle.hpp"

namespace omnimorph {

/// First-order lag on the speed: w' = (w_command - w) / tau, solved exactly over a step, w <- w_c + (w - w_c) e^(-h/tau).
/// tau is the time constant up while the rotor is asked to spin faster the same way round, down otherwise.
template <class T, int N> struct RotorLag {
    bool active = false;
    PerRotor<T, N> keep_up{}, keep_down{};  // e^(-h/tau) over the integrator's actuator step

    RotorLag() = default;
    template <class S, int M> RotorLag(const RotorLag<S, M>& o, int n)
        : active(o.active), keep_up(cast<T, N>(o.keep_up, n)), keep_down(cast<T, N>(o.keep_down, n)) {}

    T advance(int i, const T& speed, const T& command, bool time_passes) const {
        if (!active) return command;
        if (!time_passes) return speed;
        const Mask<T> faster = (abs(command) >= abs(speed)) & (command * speed >= T(0));
        const T keep = select(faster, keep_up[i], keep_down[i]);
        return command + keep * (speed - command);
    }
};

}  // namespace omnimorph
