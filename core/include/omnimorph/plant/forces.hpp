// Forces beside the rotors': each is a record with one function, wrench(now), force in W and torque in B at the centre
// of mass, which the integrator evaluates at its own stages.
#pragma once

#include "actuators.hpp"

namespace omnimorph {

/// What a force may depend on: the motion, the actuators and the time (s) at one stage of the integrator.
template <class T, int N> struct Moment {
    const Motion<T>& motion;
    const Actuators<T, N>& actuators;
    double time;
};

}  // namespace omnimorph
