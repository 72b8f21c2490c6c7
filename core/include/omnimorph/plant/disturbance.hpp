// Something pushes: force in W, torque in B, at the centre of mass.
#pragma once

#include <cmath>
#include <vector>

#include "../math/matrix.hpp"

namespace omnimorph {

/// constant + amplitude sin(frequency t + phase) + a profile interpolated linearly in time (its ends held).
template <class T> struct Disturbance {
    bool active = false;
    Vec6<T> constant = Vec6<T>::zero(), amplitude = Vec6<T>::zero();
    double frequency = 0, phase = 0;      // rad/s, rad
    std::vector<double> times, wrenches;  // s; six numbers a time

    Disturbance() = default;
    template <class S> explicit Disturbance(const Disturbance<S>& o)
        : active(o.active), constant(cast<T>(o.constant)), amplitude(cast<T>(o.amplitude)), frequency(o.frequency), phase(o.phase),
          times(o.times), wrenches(o.wrenches) {}

    Vec6<T> at(double time) const {
        Vec6<T> wrench = constant + T(std::sin(frequency * time + phase)) * amplitude;
        if (!times.empty()) add_profile(time, wrench);
        return wrench;
    }

  private:
    void add_profile(double time, Vec6<T>& wrench) const {
        std::size_t next = 0;
        while (next < times.size() && times[next] <= time) ++next;
        const std::size_t a = next == 0 ? 0 : next - 1, b = next == times.size() ? a : next;
        const double share = b == a ? 0.0 : (time - times[a]) / (times[b] - times[a]);
        for (int r = 0; r < 6; ++r) wrench[r] += T((1 - share) * wrenches[6 * a + r] + share * wrenches[6 * b + r]);
    }
};

}  // namespace omnimorph
