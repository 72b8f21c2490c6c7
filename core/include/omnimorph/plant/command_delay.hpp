// Delay from a measurement to the command that was computed from it.
#pragma once

#include "../model/motion.hpp"

namespace omnimorph {

struct CommandDelay {
    static constexpr const char* name = "command-delay";
    bool active = false;
    int steps = 0;  // of physics

    static constexpr auto fields() {
        return field_list(derived("active", &CommandDelay::active), field("steps", &CommandDelay::steps));
    }
};

/// The commands under way, and the one that has arrived last; as many can be under way as there are places.
template <class T, int N> struct DelayLine {
    static constexpr int places = 64;
    template <class X> struct Places {
        X a[places];
        OMNIMORPH_FN X& operator[](long k) { return a[k % places]; }
    };
    Command<T, N> in_force{};
    Places<Command<T, N>> under_way{};
    Places<long> arrival{};
    long oldest = 0, newest = 0;

    static constexpr auto fields() {
        using D = DelayLine;
        return field_list(field("in_force", &D::in_force), field("under_way", &D::under_way),
                          field("arrival", &D::arrival), field("oldest", &D::oldest), field("newest", &D::newest));
    }

    /// With a command in force, and none under way.
    OMNIMORPH_FN static DelayLine beginning_with(const Command<T, N>& command) {
        DelayLine line;
        line.in_force = command;
        return line;
    }

    OMNIMORPH_FN void send(int delay, long step, const Command<T, N>& command) {
        const bool replaces = oldest < newest && arrival[newest - 1] == step + delay;  // sent twice in a step
        if (!replaces) ++newest;
        arrival[newest - 1] = step + delay;
        under_way[newest - 1] = command;
    }
    OMNIMORPH_FN const Command<T, N>& arrived(long step) {
        while (oldest < newest && arrival[oldest] <= step) in_force = under_way[oldest++];
        return in_force;
    }
};

}  // namespace omnimorph
