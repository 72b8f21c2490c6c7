// The stage of tracking: from an estimate and the desired motion to the demand on allocation.
#pragma once

#include "position_first.hpp"

namespace omnimorph {

template <class T> struct TrackingSettings {
    TrackingGains<T> gains;
    PositionFirst<T> position_first;

    static constexpr auto fields() {
        return field_list(field("gains", &TrackingSettings::gains),
                          field("position-first", &TrackingSettings::position_first));
    }
};

template <class T> using TrackingState = PositionFirstState<T>;

template <class T>
OMNIMORPH_FN Demand<T> track(const TrackingSettings<T>& settings, const Motion<T>& estimate, const Desired<T>& desired,
                             TrackingState<T>& state) {
    if (!settings.position_first.active) return {reference_acceleration(estimate, desired, settings.gains)};
    const Desired<T> held = position_first(settings.position_first, estimate, desired, settings.gains, state);
    return {reference_acceleration(estimate, held, settings.gains)};
}

}  // namespace omnimorph
