// How the body is being accelerated, as an inertial sensor of its centre of mass would find it.
#pragma once

#include "plant.hpp"

namespace omnimorph {

/// The acceleration of the body at the beginning of physics step number `step`, linear (m/s²) in W and angular (rad/s²)
/// in B: what the integrator makes of the motion and the actuators as they are now, under a push from outside. The
/// actuators are held, so the torques of spinning rotors up and of turning their axes are not in it.
template <class T, int N>
OMNIMORPH_FN Vec6<T> acceleration(const Plant<T, N>& plant, const PlantState<T, N>& state, long step,
                                  const Vec6<T>& push) {
    const Vehicle<T, N>& vehicle = plant.settings.vehicle;
    const Motion<T>& motion = state.motion;
    const double time = double(step) * plant.settings.step;
    const Vec6<T> forces = forces_at<T, N>(plant, {motion, state.actuators, time}, push);
    const Vec3<T> L = vehicle.inertia * motion.w + state.load.momentum;
    const Vec3<T> torque = torque_of(state.load.wrench) + torque_of(forces) - cross(motion.w, L);
    return joined(linear_acceleration(plant, motion.R, state.load.wrench, forces), vehicle.inertia_inverse * torque);
}

}  // namespace omnimorph
