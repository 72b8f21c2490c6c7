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
    FlightState<double, 0> state() const override {
        FlightState<double, N> x{};
        x.tracking = tracking_;
        x.decided = last_;
        return convert<FlightState<double, 0>>(x);
    }
    void restore(const FlightState<double, 0>& state) override {
        const auto x = convert<FlightState<double, N>>(state);
        tracking_ = x.tracking;
        last_ = x.decided;
        cache_ = {};
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

class CountedFlight final : public AnyFlight {
  public:
    CountedFlight(const AnyLoopSettings& settings, const Reference& reference, const FlightLimits& limits,
                  const Record& record)
        : flight_(convert<LoopSettings<double, N>>(settings), reference, limits, {{record}}) {
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
    Vec6<double> acceleration() const override { return flight_.acceleration(); }
    Motion<double> measured() const override { return flight_.measured(); }
    Motion<double> estimate_from(const Motion<double>& measured) override { return flight_.estimate_from(measured); }
    Desired<double> desired() const override { return flight_.desired(); }
    AnyAllocation answer(const Motion<double>& estimate, const Demand<double>& demand) override {
        return uncounted(flight_.answer(estimate, demand));
    }
    AnyAllocation control(const Motion<double>& estimate, const Desired<double>& desired) override {
        return uncounted(flight_.control(estimate, desired));
    }
    void command(const AnyAllocation& a) override { flight_.command(convert<Allocation<double, N>>(a)); }
    void end_here(FlightStatus status) override { flight_.end_here(status); }
    void change_controller(const AnyControllerSettings& settings) override {
        flight_.change_controller(convert<ControllerSettings<double, N>>(settings));
    }
    void set_effectiveness(const PerRotor<double, 0>& share) override {
        flight_.set_effectiveness(convert<PerRotor<double, N>>(share));
    }
    void integrate(int steps, const Vec6<double>& push) override {
        for (int k = 0; k < steps && !flight_.is_over(); ++k) flight_.integrate(flight_.desired(), push);
    }
    bool finish_row() override { return flight_.finish_row(); }
    void place(const PlantState<double, 0>& outside, const PerRotor<double, 0>* thrust, const Vec6<double>& push,
               long steps_later) override {
        PerRotor<double, N> counted_thrust{};
        if (thrust != nullptr) counted_thrust = convert<PerRotor<double, N>>(*thrust);
        flight_.place(convert<PlantState<double, N>>(outside), thrust != nullptr ? &counted_thrust : nullptr, push,
                      steps_later);
    }
    FlightState<double, 0> state() const override { return convert<FlightState<double, 0>>(flight_.state()); }
    long step() const override { return flight_.state().step; }
    FlightStatus status() const override { return flight_.status(); }

    std::unique_ptr<DelayLine<double, 0>> delay_line() const override {
        if (flight_.delay_line() == nullptr) return nullptr;
        return std::make_unique<DelayLine<double, 0>>(convert<DelayLine<double, 0>>(*flight_.delay_line()));
    }
    void restore(const FlightState<double, 0>& state, const DelayLine<double, 0>* delay_line) override {
        std::unique_ptr<DelayLine<double, N>> counted_line;
        if (delay_line != nullptr)
            counted_line = std::make_unique<DelayLine<double, N>>(convert<DelayLine<double, N>>(*delay_line));
        flight_.restore(convert<FlightState<double, N>>(state), counted_line.get());
    }

  private:
    Flight<double, N> flight_;
};

}  // namespace

template <>
std::unique_ptr<AnyController> make_controller<N>(const AnyControllerSettings& settings, const AnyCommand& start) {
    return std::make_unique<CountedController>(settings, start);
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
