// A command reaches the motors some time after the measurement it was computed from.
#pragma once

#include "../model/motion.hpp"

namespace omnimorph {

/// Pure delay by a number of physics steps; as many commands can be under way as the buffer has places.
template <class T, int N> class CommandDelay {
  public:
    static constexpr int places = 64;

    CommandDelay(int steps, const Command<T, N>& start) : steps_(steps), in_force_(start) {}

    void send(long step, const Command<T, N>& command) {
        if (steps_ == 0) {
            in_force_ = command;
            return;
        }
        const bool replaces = oldest_ < newest_ && arrival_[(newest_ - 1) % places] == step + steps_;  // sent twice in a step
        if (!replaces) ++newest_;
        arrival_[(newest_ - 1) % places] = step + steps_;
        under_way_[(newest_ - 1) % places] = command;
    }
    const Command<T, N>& in_force(long step) {
        while (oldest_ < newest_ && arrival_[oldest_ % places] <= step) in_force_ = under_way_[oldest_++ % places];
        return in_force_;
    }

  private:
    int steps_;
    Command<T, N> in_force_;
    long arrival_[places] = {};
    Command<T, N> under_way_[places];
    long oldest_ = 0, newest_ = 0;
};

}  // namespace omnimorph
