// The controller and the flight behind one face for every rotor count; each count is compiled in a file of its own.
#pragma once

#include <memory>
#include <vector>

#include "omnimorph/flight/flight.hpp"

namespace omnimorph::python {

using AnyVehicle = Vehicle<double, 0>;
using AnyAllocation = Allocation<double, 0>;
using AnyCommand = Command<double, 0>;

class AnyController {
  public:
    virtual ~AnyController() = default;
    virtual AnyAllocation step(const Motion<double>& measured, const Desired<double>& desired) = 0;
    virtual AnyAllocation allocate(const Motion<double>& measured, const Vec6<double>& acceleration) = 0;
    /// One control step after the other: row k of thrust and tilt answers row k of the states and desired motions.
    virtual void replay(std::size_t steps, const Motion<double>* measured, const Desired<double>* desired, double* thrust, double* tilt) = 0;
    int n_rotors = 0, n_servos = 0;
};

class AnyFlight {
  public:
    virtual ~AnyFlight() = default;
    virtual void advance(long most_steps) = 0;
    virtual Motion<double> measure() = 0;
    virtual Motion<double> motion() const = 0;
    virtual Desired<double> desired() const = 0;
    virtual AnyAllocation control(const Motion<double>& measured, const Desired<double>& desired) = 0;
    virtual void decide(const AnyAllocation& allocation) = 0;
    virtual void refuse_command() = 0;
    virtual void change_controller(const ControllerSettings<double, 0>& settings) = 0;
    virtual void set_effectiveness(const PerRotor<double, 0>& share) = 0;
    virtual void integrate(int steps, const Vec6<double>& pushed) = 0;
    virtual PerRotor<double, 0> speed() const = 0;
    virtual PerServo<double> tilt() const = 0;
    virtual Vec6<double> wrench_achieved() const = 0;
    virtual long step() const = 0;
    virtual FlightStatus status() const = 0;
    int n_rotors = 0, n_servos = 0;
    PerRotor<double, 0> thrust_min{}, thrust_max{};  // N, by the model
};

/// A control step whose least cost at several tilts is asked for.
struct ControlStep {
    Motion<double> state;
    Vec6<double> acceleration;
    PerRotor<double, 0> previous_thrust;
};

/// Everything a flight is made of. The reference and the recorded arrays must outlive the flight.
struct FlightParts {
    PlantSettings<double, 0> plant;
    AnyVehicle model;
    ControllerSettings<double, 0> controller;
    const Reference* reference;
    Motion<double> start;
    AnyCommand command;
    FlightSettings settings;
    Record record;
};

template <int N>
std::unique_ptr<AnyController> make_controller(const AnyVehicle& vehicle, const ControllerSettings<double, 0>& settings, const AnyCommand& start);
template <int N> std::unique_ptr<AnyFlight> make_flight(const FlightParts& parts);
/// Row k holds the costs of step k at its own `tilts` angles, row k of `tilt`; the vehicle has one servo.
template <int N>
std::vector<double> cost_over_tilt(const AnyVehicle& vehicle, const AllocationWeights<double, 0>& weights, const std::vector<ControlStep>& steps,
                                   const double* tilt, std::size_t tilts);

}  // namespace omnimorph::python
