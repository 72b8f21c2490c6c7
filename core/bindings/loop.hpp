// The controller and the flight behind one face for every rotor count; each count is compiled in a file of
// its own.
#pragma once

#include <memory>
#include <vector>

#include "omnimorph/flight/flight.hpp"

namespace omnimorph::python {

using AnyVehicle = Vehicle<double, 0>;
using AnyAllocation = Allocation<double, 0>;
using AnyCommand = Command<double, 0>;
using AnyControllerSettings = ControllerSettings<double, 0>;
using AnyLoopSettings = LoopSettings<double, 0>;

class AnyController {
  public:
    virtual ~AnyController() = default;
    virtual AnyAllocation step(const Motion<double>& estimate, const Desired<double>& desired) = 0;
    virtual AnyAllocation allocate(const Motion<double>& estimate, const Demand<double>& demand) = 0;
    /// One control step after the other: row k of thrust and tilt answers row k of the states and desired motions.
    virtual void replay(std::size_t steps, const Motion<double>* estimates, const Desired<double>* desired,
                        double* thrust, double* tilt) = 0;
    /// What it remembers, as the state of a flight that holds nothing else.
    virtual FlightState<double, 0> state() const = 0;
    virtual void restore(const FlightState<double, 0>& state) = 0;
    int n_rotors = 0, n_servos = 0;
};

class AnyFlight {
  public:
    virtual ~AnyFlight() = default;
    virtual void advance(long most_steps) = 0;
    virtual Motion<double> measure() = 0;
    virtual Vec6<double> acceleration() const = 0;
    virtual Motion<double> measured() const = 0;
    virtual Motion<double> estimate_from(const Motion<double>& measured) = 0;
    virtual Desired<double> desired() const = 0;
    virtual AnyAllocation answer(const Motion<double>& estimate, const Demand<double>& demand) = 0;
    virtual AnyAllocation control(const Motion<double>& estimate, const Desired<double>& desired) = 0;
    virtual void command(const AnyAllocation& allocation) = 0;
    virtual void end_here(FlightStatus status) = 0;
    virtual void change_controller(const AnyControllerSettings& settings) = 0;
    virtual void set_effectiveness(const PerRotor<double, 0>& share) = 0;
    virtual void integrate(int steps, const Vec6<double>& push) = 0;
    virtual bool finish_row() = 0;
    virtual void place(const PlantState<double, 0>& outside, const PerRotor<double, 0>* thrust,
                       const Vec6<double>& push, long steps_later) = 0;
    virtual FlightState<double, 0> state() const = 0;
    virtual long step() const = 0;
    virtual FlightStatus status() const = 0;
    /// The commands under way, or null if there is no delay.
    virtual std::unique_ptr<DelayLine<double, 0>> delay_line() const = 0;
    virtual void restore(const FlightState<double, 0>& state, const DelayLine<double, 0>* delay_line) = 0;
    int n_rotors = 0, n_servos = 0;
    PerRotor<double, 0> thrust_min{}, thrust_max{};  // N, by the model
};

/// A control step whose least cost at several tilts is asked for.
struct ControlStep {
    Motion<double> state;
    Vec6<double> acceleration;
    PerRotor<double, 0> previous_thrust;
};

template <int N>
std::unique_ptr<AnyController> make_controller(const AnyControllerSettings& settings, const AnyCommand& start);
template <int N>
std::unique_ptr<AnyFlight> make_flight(const AnyLoopSettings& settings, const Reference& reference,
                                       const FlightLimits& limits, const Record& record);
/// Row k holds the costs of step k at its own `tilts` angles, row k of `tilt`; the vehicle has one servo.
template <int N>
std::vector<double> cost_over_tilt(const AnyControllerSettings& settings, const std::vector<ControlStep>& steps,
                                   const double* tilt, std::size_t tilts);

}  // namespace omnimorph::python
