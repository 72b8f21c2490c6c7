// The paper's controller: pose tracking, then allocation. It remembers its last command, as the paper's u* and alpha*
// do.
#pragma once

#include "allocation.hpp"
#include "position_first.hpp"

namespace omnimorph {

template <class T, int N> struct ControllerSettings {
    TrackingGains<T> gains;
    AllocationSettings<T, N> allocation;
    PositionFirst<T> position_first;

    ControllerSettings() = default;
    /// The same controller for another number type or rotor count.
    template <class S, int M> ControllerSettings(const ControllerSettings<S, M>& o, int, int)
        : gains(convert<TrackingGains<T>>(o.gains)),
          allocation(convert<AllocationSettings<T, N>>(o.allocation)),
          position_first(o.position_first) {}
};

template <class T, int N> class Controller {
  public:
    Allocation<T, N> last;

    Controller(const Vehicle<T, N>& vehicle, const ControllerSettings<T, N>& settings, const Command<T, N>& start)
        : last(first_allocation(vehicle, start)),
          settings_(settings),
          problem_(allocation_problem(vehicle, settings.allocation.weights)),
          gives_way_(settings.position_first) {}

    const Allocation<T, N>& step(const Motion<T>& measured, const Desired<T>& desired) {
        const Desired<T> held = gives_way_(measured, desired, settings_.gains);
        return allocate(measured, reference_acceleration(measured, held, settings_.gains));
    }

    const Allocation<T, N>& allocate(const Motion<T>& measured, const Vec6<T>& acceleration) {
        omnimorph::allocate(settings_.allocation, problem_, measured, Demand<T>{acceleration}, last, cache_);
        return last;
    }

  private:
    ControllerSettings<T, N> settings_;
    AllocationProblem<T, N> problem_;
    AllocationCache<T, N> cache_;
    AttitudeGivesWay<T> gives_way_;
};

}  // namespace omnimorph
