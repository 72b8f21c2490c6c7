// Every imperfection that a plant may have, each in a file of its own. A new one is a line here.
#pragma once

#include "command_delay.hpp"
#include "dead_band.hpp"
#include "pushes.hpp"
#include "rotor_lag.hpp"
#include "servos.hpp"
#include "speed_limits.hpp"

namespace omnimorph {

/// In the order in which a command passes them.
template <class T, int N> using RotorLaws = Records<SpeedLimits<T, N>, DeadBand<T, N>, RotorLag<T, N>>;
template <class T> using ServoLaws = Records<ServoLag<T>, ServoRateLimit<T>>;
/// In the order in which they are summed up.
template <class T> using Forces = Records<ConstantWrench<T>, SineWrench<T>, WrenchProfile<T>>;

}  // namespace omnimorph
