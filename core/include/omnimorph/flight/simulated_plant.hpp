// A plant by itself, without a controller: commands go in, measurements come out.
#pragma once

#include <memory>

#include "../plant/acceleration.hpp"
#include "loop.hpp"

namespace omnimorph {

template <class T, int N> class SimulatedPlant {
  public:
    /// Of the settings of a loop, all but its controller.
    SimulatedPlant(const LoopSettings<T, N>& s, NoiseKey noise)
        : plant_(s.plant),
          sensors_(s.sensors),
          settings_(s.estimator),
          noise_(noise),
          control_every_(s.control_every),
          command_(s.start.command) {
        state_ = plant_at(plant_, s.start.motion, s.start.command);
        if (s.plant.delay.steps == 0) return;
        delay_line_ = std::make_unique<DelayLine<T, N>>(DelayLine<T, N>::beginning_with(s.start.command));
    }

    const Plant<T, N>& plant() const { return plant_; }
    const PlantState<T, N>& state() const { return state_; }
    long step() const { return step_; }

    /// As it is now, under the push of the last physics step.
    Vec6<T> acceleration() const { return omnimorph::acceleration(plant_, state_, step_, push_); }

    /// What it remembers, as the state of a flight that holds nothing else.
    FlightState<T, N> stored() const {
        FlightState<T, N> x{};
        x.step = step_;
        x.plant = state_;
        x.estimator = estimator_;
        x.decided.command = command_;
        x.push = push_;
        return x;
    }
    /// Null, if commands are in force at once.
    const DelayLine<T, N>* delay_line() const { return delay_line_.get(); }

    /// Go on from what a plant like it remembered.
    void restore(const FlightState<T, N>& x, const DelayLine<T, N>* delay_line) {
        step_ = x.step;
        state_ = x.plant;
        estimator_ = x.estimator;
        command_ = x.decided.command;
        push_ = x.push;
        if (delay_line_ != nullptr && delay_line != nullptr) *delay_line_ = *delay_line;
    }

    /// The estimate of the motion in this control step.
    Motion<T> measure() {
        const auto now = static_cast<std::uint32_t>(step_ / control_every_);
        return estimate_in_step(sensors_, settings_, state_.motion, noise_, now, estimator_).motion;
    }

    void send(const Command<T, N>& command) {
        command_ = command;
        if (delay_line_ != nullptr) delay_line_->send(plant_.settings.delay.steps, step_, command);
    }

    /// One physics step under the command in force and a push (force in W, torque in B).
    void advance(const Vec6<T>& push) {
        push_ = push;
        omnimorph::advance(plant_, in_force(), step_, push, state_);
        ++step_;
    }

    /// One physics step of a body that is bolted down: its actuators go on, and it stays.
    void advance_actuators() {
        actuate(plant_, in_force(), {plant_.settings.step}, state_.actuators);
        state_.load = rotor_load(plant_, state_.actuators);
        ++step_;
    }

  private:
    const Command<T, N>& in_force() { return delay_line_ != nullptr ? delay_line_->arrived(step_) : command_; }

    Plant<T, N> plant_;
    Sensors<T> sensors_;
    Estimator<T> settings_;
    NoiseKey noise_;
    int control_every_;
    long step_ = 0;
    PlantState<T, N> state_;
    EstimatorState<T> estimator_;
    Command<T, N> command_;
    Vec6<T> push_ = Vec6<T>::zero();  // from outside, in the last physics step
    std::unique_ptr<DelayLine<T, N>> delay_line_;
};

}  // namespace omnimorph
