// A tilt servo follows its command late and only so fast.
#pragma once

#include "../model/vehicle.hpp"

namespace omnimorph {

/// First-order lag: covers the share 1 - e^(-h/tau) of what is left in a step.
template <class T> struct ServoLag {
    bool active = false;
    PerServo<T> keep{};  // e^(-h/tau) over the integrator's actuator step

    ServoLag() = default;
    template <class S> ServoLag(const ServoLag<S>& o, int m) : active(o.active), keep(cast<T>(o.keep, m)) {}

    T travel(int j, const T& way_left, bool time_passes) const {
        if (!active) return way_left;
        return time_passes ? (T(1) - keep[j]) * way_left : T(0);
    }
};

/// Travels at most the rate limit times the step.
template <class T> struct ServoRateLimit {
    bool active = false;
    PerServo<T> most{};  // rad in the integrator's actuator step

    ServoRateLimit() = default;
    template <class S> ServoRateLimit(const ServoRateLimit<S>& o, int m) : active(o.active), most(cast<T>(o.most, m)) {}

    T travel(int j, const T& wanted, bool time_passes) const {
        if (!active) return wanted;
        return time_passes ? clamp(wanted, -most[j], most[j]) : T(0);
    }
};

}  // namespace omnimorph
