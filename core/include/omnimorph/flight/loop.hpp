// The closed loop, stage by stage:
//
//     sense -> estimate -> track -> allocate -> actuate -> forces -> move
//
// Each stage is a settings record and a free function, some with a state. The state of a flight is one plain value:
// copied, it is a branch of the flight; stored, it can be resumed.
#pragma once

#include "settings.hpp"

namespace omnimorph {

enum class FlightStatus { flying, completed, lost, not_finite, diverged, part_failed };

/// One of something for each lane.
template <class X, class T> struct PerLane {
    X a[lane_count<T>];
    OMNIMORPH_FN X& operator[](int lane) { return a[lane]; }
    OMNIMORPH_FN const X& operator[](int lane) const { return a[lane]; }
};

/// Flights of as many vehicles as T has lanes.
template <class T, int N> struct FlightState {
    long step = 0;  // of physics
    PlantState<T, N> plant;
    EstimatorState<T> estimator;
    TrackingState<T> tracking;
    Allocation<T, N> decided;        // in the last control step; its command is the last that was sent
    bool decided_outside = true;     // by a controller that gives commands alone
    Vec6<T> push = Vec6<T>::zero();  // from outside, in the last physics step
    PerLane<FlightStatus, T> status{};
    PerLane<long, T> last_step{};

    static constexpr auto fields() {
        using S = FlightState;
        return field_list(field("step", &S::step), field("plant", &S::plant), field("estimator", &S::estimator),
                          field("tracking", &S::tracking), field("decided", &S::decided),
                          field("decided_outside", &S::decided_outside), field("push", &S::push),
                          field("status", &S::status), field("last_step", &S::last_step));
    }
};

/// What goes with a state: the commands under way, if there is a delay, and the caches of allocation. Who steps a loop
/// by hand gives a plant with a delay its line, which begins with the first command `in_force`; without a line
/// commands are in force at once. At most `places` commands may be under way: a delay is at most so many control steps.
template <class T, int N> struct StepMemory {
    AllocationCache<T, N> allocation;
    DelayLine<T, N>* delay_line = nullptr;
};

/// The stages, ready to step: their settings and what follows from them.
template <class T, int N> struct Loop {
    Sensors<T> sensors;
    Estimator<T> estimator;
    TrackingSettings<T> tracking;
    AllocationSettings<T, N> allocation;
    AllocationProblem<T, N> problem;
    Plant<T, N> plant;
    int control_every;
    long steps;      // of physics, after which nothing more is decided
    NoiseKey noise;  // of the vehicle in lane 0

    OMNIMORPH_FN Loop(const LoopSettings<T, N>& s, long steps_in_all, NoiseKey key)
        : sensors(s.sensors),
          estimator(s.estimator),
          tracking(s.controller.tracking),
          allocation(s.controller.allocation),
          problem(allocation_problem(s.controller.model, s.controller.allocation.weights)),
          plant(s.plant),
          control_every(s.control_every),
          steps(steps_in_all),
          noise(key) {}
};

/// A flight that begins: the actuators are as the first command asks, which no controller decided.
template <class T, int N>
OMNIMORPH_FN FlightState<T, N> state_at(const Loop<T, N>& loop, const FlightStart<T, N>& start) {
    FlightState<T, N> x{};
    x.plant = plant_at(loop.plant, start.motion, start.command);
    x.decided.command = start.command;
    x.decided.cost = x.decided.kkt_residual = T(std::nan(""));
    for (int c = 0; c < 6; ++c) x.decided.wrench_asked[c] = x.decided.cost;
    for (int i = 0; i < loop.plant.n(); ++i) x.decided.active[i] = T(0);
    return x;
}

template <class T, int N> OMNIMORPH_FN bool control_is_due(const Loop<T, N>& loop, const FlightState<T, N>& x) {
    return x.step % loop.control_every == 0 && x.step < loop.steps;
}
template <class T, int N> OMNIMORPH_FN std::uint32_t control_step(const Loop<T, N>& loop, const FlightState<T, N>& x) {
    return static_cast<std::uint32_t>(x.step / loop.control_every);
}

/// Put the command that was decided on its way to the motors.
template <class T, int N>
OMNIMORPH_FN void send(const Loop<T, N>& loop, const FlightState<T, N>& x, StepMemory<T, N>& memory) {
    if (memory.delay_line != nullptr)
        memory.delay_line->send(loop.plant.settings.delay.steps, x.step, x.decided.command);
}
template <class T, int N>
OMNIMORPH_FN const Command<T, N>& command_in_force(const FlightState<T, N>& x, StepMemory<T, N>& memory) {
    return memory.delay_line != nullptr ? memory.delay_line->arrived(x.step) : x.decided.command;
}

/// From a demand to the command that answers it, which is sent.
template <class T, int N>
OMNIMORPH_FN void allocate(const Loop<T, N>& loop, const Motion<T>& known, const Demand<T>& demand,
                           FlightState<T, N>& x, StepMemory<T, N>& memory) {
    allocate(loop.allocation, loop.problem, known, demand, x.decided, memory.allocation);
    x.decided_outside = false;
    send(loop, x, memory);
}

/// actuate -> forces -> move: one physics step; the plant's integrator takes the three at its own stages.
template <class T, int N>
OMNIMORPH_FN void move(const Loop<T, N>& loop, const Vec6<T>& push, FlightState<T, N>& x, StepMemory<T, N>& memory) {
    advance(loop.plant, command_in_force(x, memory), x.step, push, x.plant);
    ++x.step;
}

/// One step of the whole loop: a decision, where one is due, and a physics step under a push from outside. Between the
/// two `goes_on` sees what was decided, and may end it there.
template <class T, int N, class GoesOn>
OMNIMORPH_FN void step(const Loop<T, N>& loop, const Desired<T>& desired, const Vec6<T>& push, FlightState<T, N>& x,
                       StepMemory<T, N>& memory, GoesOn&& goes_on) {
    if (control_is_due(loop, x)) {
        const Measurement<T> measured = sense(loop.sensors, x.plant.motion, loop.noise, control_step(loop, x));
        const Estimate<T> known = estimate(loop.estimator, measured, x.estimator);
        const Demand<T> demand = track(loop.tracking, known.motion, desired, x.tracking);
        allocate(loop, known.motion, demand, x, memory);
    }
    if (goes_on()) move(loop, push, x, memory);
}
template <class T, int N>
OMNIMORPH_FN void step(const Loop<T, N>& loop, const Desired<T>& desired, const Vec6<T>& push, FlightState<T, N>& x,
                       StepMemory<T, N>& memory) {
    step(loop, desired, push, x, memory, [] { return true; });
}

}  // namespace omnimorph
