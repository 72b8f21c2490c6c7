// The paper's controller: pose tracking, then allocation. It remembers its last command, as the paper's u* and alpha* do.
#pragma once

#include "joint_allocate.hpp"
#include "position_first.hpp"

namespace omnimorph {

enum class AllocationRule { fixed_tilt, best_in_window, towards_best_in_range, jointly };

template <class T, int N> struct ControllerSettings {
    TrackingGains<T> gains;
    AllocationWeights<T, N> weights;
    AllocationRule rule;
    PerServo<T> tilt_change;  // epsilon: each servo's rate limit times the control period, rad
    PositionFirst<T> position_first;
    int candidates;           // tilts tried, an odd number; three in the window are the paper's

    ControllerSettings() = default;
    /// The same controller for another number type or rotor count.
    template <class S, int M> ControllerSettings(const ControllerSettings<S, M>& o, int n, int m)
        : gains{cast<T>(o.gains.velocity), cast<T>(o.gains.position), cast<T>(o.gains.rate), cast<T>(o.gains.attitude)},
          weights{cast<T, N>(o.weights.input, n), cast<T, N>(o.weights.input_change, n), cast<T>(o.weights.acceleration),
                  T(o.weights.tilt_change)},
          rule(o.rule),
          tilt_change(cast<T>(o.tilt_change, m)),
          position_first(o.position_first),
          candidates(o.candidates) {}
};

template <class T, int N> class Controller {
  public:
    Allocation<T, N> last;

    Controller(const Vehicle<T, N>& vehicle, const ControllerSettings<T, N>& settings, const Command<T, N>& start)
        : settings_(settings), allocator_(vehicle, settings.weights), gives_way_(settings.position_first) {
        last.command = start;
        last.cost = last.kkt_residual = T(0);
        last.wrench_asked = Vec6<T>::zero();
        for (int i = 0; i < vehicle.n_rotors; ++i) last.active[i] = T(0);
    }

    const Allocation<T, N>& step(const Motion<T>& measured, const Desired<T>& desired) {
        const Desired<T> held = gives_way_(measured, desired, settings_.gains);
        return allocate(measured, reference_acceleration(measured, held, settings_.gains));
    }

    const Allocation<T, N>& allocate(const Motion<T>& measured, const Vec6<T>& acceleration) {
        switch (settings_.rule) {
            case AllocationRule::fixed_tilt: allocator_.at_fixed_tilt(measured, acceleration, last); break;
            case AllocationRule::best_in_window:
                allocator_.best_in_window(measured, acceleration, last, settings_.tilt_change[0], settings_.candidates);
                break;
            case AllocationRule::towards_best_in_range:
                allocator_.towards_best_in_range(measured, acceleration, last, settings_.tilt_change[0], settings_.candidates);
                break;
            case AllocationRule::jointly: allocator_.jointly(measured, acceleration, last, settings_.tilt_change); break;
        }
        return last;
    }

  private:
    ControllerSettings<T, N> settings_;
    JointAllocator<T, N> allocator_;
    AttitudeGivesWay<T> gives_way_;
};

}  // namespace omnimorph
