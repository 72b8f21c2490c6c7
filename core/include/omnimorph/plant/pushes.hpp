// External wrenches, force in W and torque in B at the centre of mass: constant, a sine over time, or a table.
#pragma once

#include "forces.hpp"

namespace omnimorph {

template <class T> struct ConstantWrench {
    static constexpr const char* name = "constant-wrench";
    bool active = false;
    Vec6<T> constant = Vec6<T>::zero();

    static constexpr auto fields() {
        return field_list(derived("active", &ConstantWrench::active), field("constant", &ConstantWrench::constant));
    }

    template <class Moment> OMNIMORPH_FN Vec6<T> wrench(const Moment&) const { return constant; }
};

/// amplitude sin(frequency t + phase)
template <class T> struct SineWrench {
    static constexpr const char* name = "sine-wrench";
    bool active = false;
    Vec6<T> amplitude = Vec6<T>::zero();
    double frequency = 0, phase = 0;  // rad/s, rad

    static constexpr auto fields() {
        return field_list(derived("active", &SineWrench::active), field("amplitude", &SineWrench::amplitude),
                          field("frequency", &SineWrench::frequency), field("phase", &SineWrench::phase));
    }

    template <class Moment> OMNIMORPH_FN Vec6<T> wrench(const Moment& now) const {
        return T(std::sin(frequency * now.time + phase)) * amplitude;
    }
};

/// A table over time, interpolated linearly, its ends held.
template <class T> struct WrenchProfile {
    static constexpr const char* name = "wrench-profile";
    bool active = false;
    Table profile;  // rows of t (s) and six numbers

    static constexpr auto fields() {
        return field_list(derived("active", &WrenchProfile::active), field("profile", &WrenchProfile::profile));
    }

    template <class Moment> OMNIMORPH_FN Vec6<T> wrench(const Moment& now) const {
        const double* rows = profile.numbers;
        const long count = profile.size / 7;
        long next = 0;
        while (next < count && rows[7 * next] <= now.time) ++next;
        const long a = next == 0 ? 0 : next - 1, b = next == count ? a : next;
        const double* from = rows + 7 * a;
        const double* to = rows + 7 * b;
        const double share = b == a ? 0.0 : (now.time - from[0]) / (to[0] - from[0]);
        Vec6<T> wrench;
        for (int r = 0; r < 6; ++r) wrench[r] = T((1 - share) * from[1 + r] + share * to[1 + r]);
        return wrench;
    }
};

}  // namespace omnimorph
