// The paper's controller: pose tracking, then allocation. It remembers its last command, as the paper's u* and alpha* do.
#pragma once

#include "allocate.hpp"

namespace omnimorph {

enum class AllocationRule { fixed_tilt, three_candidates };

template <class T, int N> struct ControllerSettings {
    TrackingGains<T> gains;
    AllocationWeights<T, N> weights;
    AllocationRule rule;
    T tilt_change;  // epsilon: the servo's rate limit times the control period, rad

    ControllerSettings() = default;
    /// The same controller for another number type or rotor count.
    template <class S, int M> ControllerSettings(const ControllerSettings<S, M>& o, int n)
        : gains{cast<T>(o.gains.velocity), cast<T>(o.gains.position), cast<T>(o.gains.rate), cast<T>(o.gains.attitude)},
          weights{cast<T, N>(o.weights.input, n), cast<T, N>(o.weights.input_change, n), cast<T>(o.weights.acceleration)},
          rule(o.rule),
          tilt_change(T(o.tilt_change)) {}
};

template <class T, int N> class Controller {
  public:
    Allocation<T, N> last;

    Controller(const Vehicle<T, N>& vehicle, const ControllerSettings<T, N>& settings, const Command<T, N>& start)
        : settings_(settings), allocator_(vehicle, settings.weights) {
        last.command = start;
        last.cost = last.kkt_residual = T(0);
        last.wrench_asked = Vec6<T>::zero();
        for (int i = 0; i < vehicle.n_rotors; ++i) last.active[i] = T(0);
    }

    const Allocation<T, N>& step(const Motion<T>& measured, const Desired<T>& desired) {
        return allocate(measured, reference_acceleration(measured, desired, settings_.gains));
    }

    const Allocation<T, N>& allocate(const Motion<T>& measured, const Vec6<T>& acceleration) {
        last = settings_.rule == AllocationRule::three_candidates
                   ? allocator_.best_of_three(measured, acceleration, last, settings_.tilt_change)
                   : allocator_.at_fixed_tilt(measured, acceleration, last);
        return last;
    }

  private:
    ControllerSettings<T, N> settings_;
    Allocator<T, N> allocator_;
};

}  // namespace omnimorph
