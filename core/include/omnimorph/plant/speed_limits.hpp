// Limits of the rotor speeds.
#pragma once

#include "actuators.hpp"

namespace omnimorph {

template <class T, int N> struct SpeedLimits {
    static constexpr const char* name = "speed-limits";
    bool active = false;
    PerRotor<T, N> speed_min{}, speed_max{};  // rad/s

    static constexpr auto fields() {
        return field_list(derived("active", &SpeedLimits::active), field("speed_min", &SpeedLimits::speed_min),
                          field("speed_max", &SpeedLimits::speed_max));
    }

    OMNIMORPH_FN T follow(int i, const T& command, Rotor<T>, ActuatorStep) const {
        return clamp(command, speed_min[i], speed_max[i]);
    }
};

}  // namespace omnimorph
