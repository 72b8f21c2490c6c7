// The motion of the vehicle, the desired one, and a command to the actuators: what the stages of the loop exchange.
#pragma once

#include "vehicle.hpp"

namespace omnimorph {

/// Motion of the body: position and velocity of the centre of mass in W, attitude R_WB, body rate in B.
template <class T> struct Motion {
    Vec3<T> p, v;
    Mat3<T> R;
    Vec3<T> w;

    static constexpr auto fields() {
        using M = Motion;
        return field_list(field("p", &M::p), field("v", &M::v), field("R", &M::R), field("w", &M::w));
    }
};

/// One point of a reference: the motion and its accelerations (dp²/dt² in W, dw/dt in B).
template <class T> struct Desired {
    Vec3<T> p, v;
    Mat3<T> R;
    Vec3<T> w;
    Vec3<T> a, dw;
};

/// A command to the actuators: thrusts in N and servo angles in rad.
template <class T, int N> struct Command {
    PerRotor<T, N> thrust;
    PerServo<T> tilt;

    static constexpr auto fields() {
        return field_list(field("thrust", &Command::thrust), field("tilt", &Command::tilt));
    }
};

}  // namespace omnimorph
