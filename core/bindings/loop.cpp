// Compiled once for each rotor count (OMNIMORPH_ROTORS; 0 counts at run time): see loop.hpp.
#include "loop.hpp"

namespace omnimorph::python {

namespace {

constexpr int N = OMNIMORPH_ROTORS;

Command<double, N> counted(const AnyCommand& command) {
    return convert<Command<double, N>>(command);
}
AnyAllocation uncounted(const Allocation<double, N>& allocation) {
    return convert<AnyAllocation>(allocation);
}

class CountedController final : public AnyController {
  public:
    CountedController(const AnyControllerSettings& settings, const AnyCommand& start)
        : settings_(convert<ControllerSettings<double, N>>(settings)),
          problem_(allocation_problem(settings_.model, settings_.allocation.weights)) {
        n_rotors = settings.model.n_rotors;
        n_servos = settings.model.n_servos;
        last_.command = counted(start);
    }
    AnyAllocation step(const Motion<double>& estimate, const Desired<double>& desired) override {
        return uncounted(decided(estimate, desired));
    }
    AnyAllocation allocate(const Motion<double>& estimate, const Demand<double>& demand) override {
        omnimorph::allocate(settings_.allocation, problem_, estimate, demand, last_, cache_);
        return uncounted(last_);
    }
    void replay(std::size_t steps, const Motion<double>* estimates, const Desired<double>* desired, double* thrust,
                double* tilt) override {
        for (std::size_t k = 0; k < steps; ++k) {
            const Command<double, N>& command = decided(estimates[k], desired[k]).command;
            for (int i = 0; i < n_rotors; ++i) *thrust++ = command.thrust[i];
            for (int j = 0; j < n_servos; ++j) *tilt++ = command.tilt[j];
        }
    }

  private:
    const Allocation<double, N>& decided(const Motion<double>& estimate, const Desired<double>& desired) {
        const Demand<double> demand = track(settings_.tracking, estimate, desired, tracking_);
        omnimorph::allocate(settings_.allocation, problem_, estimate, demand, last_, cache_);
        return last_;
    }

    ControllerSettings<double, N> settings_;
    AllocationProblem<double, N> problem_;
    TrackingState<double> tracking_;
    Allocation<double, N> last_{};
    AllocationCache<double, N> cache_{};
};

class CountedPlant final : public AnyPlant {
  public:
    CountedPlant(const AnyLoopSettings& settings, NoiseKey noise)
        : plant_(convert<LoopSettings<double, N>>(settings), noise) {
        n_rotors = settings.plant.vehicle.n_rotors;
        n_servos = settings.plant.vehicle.n_servos;
    }
    Motion<double> measure() override { return plant_.measure(); }
    void send(const AnyCommand& command) override { plant_.send(counted(command)); }
    void advance(const Vec6<double>& push) override { plant_.advance(push); }
    void advance_actuators() override { plant_.advance_actuators(); }
    PlantState<double, 0> state() const override { return convert<PlantState<double, 0>>(plant_.state()); }
    Vec6<double> hub_load(int rotor) const override {
        return omnimorph::hub_load(plant_.plant(), plant_.state().actuators, rotor);
    }
    long step() const override { return plant_.step(); }

  private:
    SimulatedPlant<double, N> plant_;
};

class CountedFlight final : public AnyFlight {
  public:
    CountedFlight(const AnyLoopSettings& settings, const Reference& reference, const FlightLimits& limits,
                  const Record& record)
        : steps_(limits.steps), flight_(convert<LoopSettings<double, N>>(settings), reference, limits, {{record}}) {
        const AnyVehicle& model = settings.controller.model;
        n_rotors = model.n_rotors;
        n_servos = model.n_servos;
        for (int i = 0; i < n_rotors; ++i) {
            thrust_min[i] = model.thrust_min(i);
            thrust_max[i] = model.thrust_max(i);
        }
    }
    void advance(long most_steps) override { flight_.advance(most_steps); }
    Motion<double> measure() override { return flight_.measure(); }
    Desired<double> desired() const override { return flight_.desired(); }
    AnyAllocation control(const Motion<double>& estimate, const Desired<double>& desired) override {
        return uncounted(flight_.control(estimate, desired));
    }
    void command(const AnyAllocation& a) override { flight_.command(convert<Allocation<double, N>>(a)); }
    void refuse_command() override { flight_.refuse_command(); }
    void change_controller(const AnyControllerSettings& settings) override {
        flight_.change_controller(convert<ControllerSettings<double, N>>(settings));
    }
    void set_effectiveness(const PerRotor<double, 0>& share) override {
        flight_.set_effectiveness(convert<PerRotor<double, N>>(share));
    }
    void integrate(int steps, const Vec6<double>& push) override {
        for (int k = 0; k < steps && !flight_.is_over(); ++k) flight_.integrate(flight_.desired(), push);
    }
    FlightState<double, 0> state() const override { return convert<FlightState<double, 0>>(flight_.state()); }
    long step() const override { return flight_.state().step; }
    FlightStatus status() const override { return flight_.status(); }

    std::vector<unsigned char> store() const override {
        if (flight_.delay_line() == nullptr) return omnimorph::store(header(), state(), nullptr);
        const auto line = std::make_unique<DelayLine<double, 0>>(convert<DelayLine<double, 0>>(*flight_.delay_line()));
        return omnimorph::store(header(), state(), line.get());
    }
    Stored restore(const std::vector<unsigned char>& bytes) override {
        FlightState<double, 0> state{};
        const auto line = std::make_unique<DelayLine<double, 0>>();
        const bool has_line = flight_.delay_line() != nullptr;
        const Stored outcome = read_state(bytes, header(), state, has_line ? line.get() : nullptr);
        if (outcome != Stored::read) return outcome;
        if (state.step > steps_) return Stored::broken;
        const auto counted_line = std::make_unique<DelayLine<double, N>>(convert<DelayLine<double, N>>(*line));
        flight_.restore(convert<FlightState<double, N>>(state), has_line ? counted_line.get() : nullptr);
        return outcome;
    }

  private:
    StateHeader header() const {
        StateHeader h;
        h.n_rotors = n_rotors;
        h.n_servos = n_servos;
        h.has_delay_line = flight_.delay_line() != nullptr;
        return h;
    }

    long steps_;
    Flight<double, N> flight_;
};

}  // namespace

template <>
std::unique_ptr<AnyController> make_controller<N>(const AnyControllerSettings& settings, const AnyCommand& start) {
    return std::make_unique<CountedController>(settings, start);
}
template <> std::unique_ptr<AnyPlant> make_plant<N>(const AnyLoopSettings& settings, NoiseKey noise) {
    return std::make_unique<CountedPlant>(settings, noise);
}
template <>
std::unique_ptr<AnyFlight> make_flight<N>(const AnyLoopSettings& settings, const Reference& reference,
                                          const FlightLimits& limits, const Record& record) {
    return std::make_unique<CountedFlight>(settings, reference, limits, record);
}

template <>
std::vector<double> cost_over_tilt<N>(const AnyControllerSettings& settings, const std::vector<ControlStep>& steps,
                                      const double* tilt, std::size_t tilts) {
    const auto counted_settings = convert<ControllerSettings<double, N>>(settings);
    const auto problem = allocation_problem(counted_settings.model, counted_settings.allocation.weights);
    std::vector<double> cost(steps.size() * tilts);
    Allocation<double, N> previous{};  // the search for the active bounds begins with none
    for (std::size_t k = 0; k < steps.size(); ++k) {
        previous.command.thrust = convert<PerRotor<double, N>>(steps[k].previous_thrust);
        omnimorph::cost_over_tilt(problem, steps[k].state, Demand<double>{steps[k].acceleration}, previous,
                                  tilt + k * tilts, static_cast<int>(tilts), cost.data() + k * tilts);
    }
    return cost;
}

}  // namespace omnimorph::python
