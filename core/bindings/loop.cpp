// Compiled once for each rotor count (OMNIMORPH_ROTORS; 0 counts at run time): see loop.hpp.
#include "loop.hpp"

namespace omnimorph::python {

namespace {

constexpr int N = OMNIMORPH_ROTORS;

Command<double, N> counted(const AnyCommand& command, int n) { return {cast<double, N>(command.thrust, n), command.tilt}; }

AnyAllocation uncounted(const Allocation<double, N>& a, int n) {
    return {{cast<double, 0>(a.command.thrust, n), a.command.tilt}, cast<double, 0>(a.active, n), a.cost, a.kkt_residual, a.wrench_asked};
}

class CountedController final : public AnyController {
  public:
    CountedController(const AnyVehicle& vehicle, const ControllerSettings<double, 0>& settings, const AnyCommand& start)
        : controller_(convert<Vehicle<double, N>>(vehicle), {settings, vehicle.n_rotors, vehicle.n_servos}, counted(start, vehicle.n_rotors)) {
        n_rotors = vehicle.n_rotors;
        n_servos = vehicle.n_servos;
    }
    AnyAllocation step(const Motion<double>& measured, const Desired<double>& desired) override {
        return uncounted(controller_.step(measured, desired), n_rotors);
    }
    AnyAllocation allocate(const Motion<double>& measured, const Vec6<double>& acceleration) override {
        return uncounted(controller_.allocate(measured, acceleration), n_rotors);
    }

    void replay(std::size_t steps, const Motion<double>* measured, const Desired<double>* desired, double* thrust, double* tilt) override {
        for (std::size_t k = 0; k < steps; ++k) {
            const Command<double, N>& command = controller_.step(measured[k], desired[k]).command;
            for (int i = 0; i < n_rotors; ++i) *thrust++ = command.thrust[i];
            for (int j = 0; j < n_servos; ++j) *tilt++ = command.tilt[j];
        }
    }

  private:
    Controller<double, N> controller_;
};

class CountedFlight final : public AnyFlight {
  public:
    explicit CountedFlight(const FlightParts& parts)
        : model_(convert<Vehicle<double, N>>(parts.model)),
          flight_(PlantSettings<double, N>(parts.plant), model_,
                  ControllerSettings<double, N>(parts.controller, parts.model.n_rotors, parts.model.n_servos), *parts.reference, parts.start,
                  counted(parts.command, parts.model.n_rotors), parts.settings, {parts.record}) {
        n_rotors = parts.model.n_rotors;
        n_servos = parts.model.n_servos;
        for (int i = 0; i < n_rotors; ++i) {
            thrust_min[i] = parts.model.thrust_min(i);
            thrust_max[i] = parts.model.thrust_max(i);
        }
    }
    void advance(long most_steps) override { flight_.advance(most_steps); }
    Motion<double> measure() override { return flight_.measure(); }
    Motion<double> motion() const override { return flight_.plant.motion; }
    Desired<double> desired() const override { return flight_.desired(); }
    AnyAllocation control(const Motion<double>& measured, const Desired<double>& desired) override {
        return uncounted(flight_.control(measured, desired), n_rotors);
    }
    void decide(const AnyAllocation& a) override {
        flight_.decide({counted(a.command, n_rotors), cast<double, N>(a.active, n_rotors), a.cost, a.kkt_residual, a.wrench_asked});
    }
    void refuse_command() override { flight_.refuse_command(); }
    void change_controller(const ControllerSettings<double, 0>& settings) override {
        flight_.change_controller(model_, {settings, n_rotors, n_servos});
    }
    void set_effectiveness(const PerRotor<double, 0>& share) override { flight_.plant.set_effectiveness(cast<double, N>(share, n_rotors)); }
    void integrate(int steps, const Vec6<double>& pushed) override {
        for (int k = 0; k < steps && !flight_.is_over(); ++k) flight_.integrate(flight_.desired(), pushed);
    }
    PerRotor<double, 0> speed() const override { return cast<double, 0>(flight_.plant.actuators.speed, n_rotors); }
    PerServo<double> tilt() const override { return flight_.plant.actuators.tilt; }
    Vec6<double> wrench_achieved() const override { return flight_.plant.wrench_achieved(); }
    long step() const override { return flight_.step; }
    FlightStatus status() const override { return flight_.status(); }

  private:
    Vehicle<double, N> model_;
    Flight<double, N> flight_;
};

}  // namespace

template <>
std::unique_ptr<AnyController> make_controller<N>(const AnyVehicle& vehicle, const ControllerSettings<double, 0>& settings, const AnyCommand& start) {
    return std::make_unique<CountedController>(vehicle, settings, start);
}
template <> std::unique_ptr<AnyFlight> make_flight<N>(const FlightParts& parts) { return std::make_unique<CountedFlight>(parts); }

template <>
std::vector<double> cost_over_tilt<N>(const AnyVehicle& vehicle, const AllocationWeights<double, 0>& weights, const std::vector<ControlStep>& steps,
                                      const double* tilt, std::size_t tilts) {
    const int n = vehicle.n_rotors;
    const auto problem = allocation_problem(convert<Vehicle<double, N>>(vehicle), convert<AllocationWeights<double, N>>(weights));
    std::vector<double> cost(steps.size() * tilts);
    Allocation<double, N> previous{};  // the search for the active bounds begins with none
    for (std::size_t k = 0; k < steps.size(); ++k) {
        previous.command.thrust = cast<double, N>(steps[k].previous_thrust, n);
        omnimorph::cost_over_tilt(problem, steps[k].state, Demand<double>{steps[k].acceleration}, previous, tilt + k * tilts, static_cast<int>(tilts), cost.data() + k * tilts);
    }
    return cost;
}

}  // namespace omnimorph::python
