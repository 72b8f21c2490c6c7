// The actuators: how fast the rotors turn and where the servos stand, and the laws between a command and that.
//
// A law is a record with one function. A rotor's command passes through the laws of rotors one after the other, and
// what the last one gives is the new speed; what is left of a servo's travel to its command passes through the laws of
// servos.
#pragma once

#include "../model/motion.hpp"

namespace omnimorph {

/// Actual speeds and tilts.
template <class T, int N> struct Actuators {
    PerRotor<T, N> speed;      // rad/s
    PerRotor<T, N> rest_left;  // s, see DeadBand
    PerServo<T> tilt;          // rad

    static constexpr auto fields() {
        return field_list(field("speed", &Actuators::speed), field("rest_left", &Actuators::rest_left),
                          field("tilt", &Actuators::tilt));
    }
};

/// The time over which actuators are advanced: a step of the integrator, or none, after which only what follows a
/// command at once has changed.
struct ActuatorStep {
    double length;  // s
    OMNIMORPH_FN bool passes() const { return length > 0; }
};

/// What a law may change of one rotor besides its command.
template <class T> struct Rotor {
    T& speed;
    T& rest_left;
};

/// What is left of a state after the time h, with a lag of time constant tau: e^(-h/tau); nothing if there is none.
OMNIMORPH_FN double decay(double h, double tau) {
    return tau > 0 ? std::exp(-h / tau) : 0.0;
}

}  // namespace omnimorph
