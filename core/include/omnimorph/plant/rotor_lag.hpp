// Lag of the rotor speeds.
#pragma once

#include "actuators.hpp"

namespace omnimorph {

/// First-order lag on the speed: w' = (w_command - w) / tau, solved exactly over a step, w <- w_c + (w - w_c)
/// e^(-h/tau). tau is the time constant up while the rotor is asked to spin faster the same way round, down otherwise.
template <class T, int N> struct RotorLag {
    static constexpr const char* name = "rotor-lag";
    bool active = false;
    PerRotor<T, N> up{}, down{};            // tau, s
    PerRotor<T, N> keep_up{}, keep_down{};  // e^(-h/tau) over the integrator's actuator step

    static constexpr auto fields() {
        return field_list(derived("active", &RotorLag::active), field("up", &RotorLag::up),
                          field("down", &RotorLag::down), derived("keep_up", &RotorLag::keep_up),
                          derived("keep_down", &RotorLag::keep_down));
    }

    OMNIMORPH_FN T follow(int i, const T& command, Rotor<T> rotor, ActuatorStep step) const {
        if (!step.passes()) return rotor.speed;
        const Mask<T> faster = (abs(command) >= abs(rotor.speed)) & (command * rotor.speed >= T(0));
        const T keep = select(faster, keep_up[i], keep_down[i]);
        return command + keep * (rotor.speed - command);
    }
};

/// Set what follows from the other fields, for n rotors and the integrator's actuator step h.
template <int N> OMNIMORPH_FN void derive(RotorLag<double, N>& lag, int n, int, double h) {
    for (int i = 0; i < n; ++i) {
        lag.keep_up[i] = decay(h, lag.up[i]);
        lag.keep_down[i] = decay(h, lag.down[i]);
    }
}

}  // namespace omnimorph
