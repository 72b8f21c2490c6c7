// Between Python's dicts and the records of the core, by their lists of fields.
#pragma once

#include <nanobind/stl/string.h>

#include <memory>
#include <set>

#include "arrays.hpp"
#include "omnimorph/flight/settings.hpp"
#include "omnimorph/math/pack.hpp"

namespace omnimorph::python {

/// The texts that stand for the values of a choice, in order.
inline std::vector<std::string> texts_of(Integrator) {
    return {"semi-implicit-euler", "runge-kutta-4"};
}
inline std::vector<std::string> texts_of(WakeModel) {
    return {"published", "blade-element"};
}
inline std::vector<std::string> texts_of(TiltSpan) {
    return {"window", "range"};
}

/// Tables that records point to, kept for as long as they are read.
using Tables = std::vector<std::shared_ptr<const double[]>>;

/// Reads records of a vehicle with n rotors and m servos.
class RecordReader {
  public:
    RecordReader(int n, int m, Tables& tables) : n_(n), m_(m), tables_(tables) {}

    /// Every field of a record from a dict, which has no others; a record with a field `active` may be left out, and is
    /// not.
    template <class Record> void read(Record& record, const nb::dict& dict, const std::string& place) {
        std::set<std::string> known;
        for_each_field(record, [&](const auto& field, auto& member) {
            using Member = std::decay_t<decltype(member)>;
            if constexpr (fields::is_list<Member>) {
                for_each(member, [&](auto& one) {
                    known.insert(one.name);
                    read_if_there(one, dict, one.name, place);
                });
            } else if (!field.is_derived) {
                known.insert(field.name);
                read_field(member, dict, field.name, place);
            }
        });
        for (const auto& [key, value] : dict)
            if (known.count(nb::cast<std::string>(key)) == 0) fail(place, "has no field " + nb::cast<std::string>(key));
    }

  private:
    template <class X, class = void> struct HasActive : std::false_type {};
    template <class X> struct HasActive<X, std::void_t<decltype(std::declval<X&>().active)>> : std::true_type {};
    /// A plant alone has no controller.
    template <class X>
    static constexpr bool may_be_left_out = HasActive<X>::value || std::is_same_v<X, ControllerSettings<double, 0>>;

    [[noreturn]] static void fail(const std::string& place, const std::string& problem) {
        throw nb::value_error((place + " " + problem).c_str());
    }

    template <class Member>
    void read_field(Member& member, const nb::dict& dict, const char* name, const std::string& place) {
        if constexpr (may_be_left_out<Member>) {
            read_if_there(member, dict, name, place);
        } else {
            if (!dict.contains(name)) fail(place, "lacks its field " + std::string(name));
            read_value(member, dict[name], place + "." + name);
        }
    }
    template <class Record>
    void read_if_there(Record& record, const nb::dict& dict, const char* name, const std::string& place) {
        if (!dict.contains(name)) return;
        if constexpr (HasActive<Record>::value) record.active = true;
        read_value(record, dict[name], place + "." + name);
    }

    template <class X> void read_value(X& x, nb::handle value, const std::string& place) {
        if constexpr (fields::is_record<X>) {
            if (nb::isinstance<X>(value)) {
                x = nb::cast<const X&>(value);
            } else {
                read(x, nb::cast<nb::dict>(value), place);
            }
        } else if constexpr (fields::is_choice<X>) {
            const auto pair = nb::cast<nb::tuple>(value);
            read_choice(x, nb::cast<std::string>(pair[0]), pair[1], place,
                        std::make_index_sequence<std::variant_size_v<X>>());
        } else if constexpr (fields::is_array<X>) {
            read_array(x, value, place);
        } else if constexpr (std::is_same_v<X, Table>) {
            const auto array = nb::cast<Array>(value, false);
            const std::shared_ptr<double[]> copy(new double[array.size()]);
            std::copy_n(array.data(), array.size(), copy.get());
            tables_.push_back(copy);
            x = {copy.get(), static_cast<long>(array.size())};
        } else if constexpr (std::is_enum_v<X>) {
            const auto texts = texts_of(x);
            const auto found = std::find(texts.begin(), texts.end(), nb::cast<std::string>(value));
            if (found == texts.end()) fail(place, "is none of the texts it may be");
            x = static_cast<X>(found - texts.begin());
        } else {
            x = nb::cast<X>(value);
        }
    }

    template <class Choice, std::size_t... I>
    void read_choice(Choice& choice, const std::string& name, nb::handle value, const std::string& place,
                     std::index_sequence<I...>) {
        const auto read_one = [&](auto index) {
            using Record = std::variant_alternative_t<index, Choice>;
            if (name != Record::name) return false;
            read_value(choice.template emplace<index>(), value, place + "." + name);
            return true;
        };
        if (!(read_one(std::integral_constant<std::size_t, I>()) || ...)) fail(place, "has no rule " + name);
    }

    /// Numbers of one rotor, one servo or one vector after the other.
    template <class X> void read_array(X& x, nb::handle value, const std::string& place) {
        using Number = std::remove_all_extents_t<std::remove_reference_t<decltype(fields::elements_of(x)[0])>>;
        using Scalar = std::conditional_t<std::is_same_v<Number, int>, std::int64_t, double>;
        const auto array = nb::cast<nb::ndarray<const Scalar, nb::c_contig, nb::device::cpu>>(value, false);
        const std::size_t size = size_of(x);
        if (array.size() != size)
            fail(place, "has " + std::to_string(array.size()) + " numbers, not " + std::to_string(size));
        using Leaf = std::conditional_t<std::is_same_v<Number, int>, int, double>;
        auto* to = reinterpret_cast<Leaf*>(&x);
        for (std::size_t k = 0; k < size; ++k) to[k] = static_cast<Leaf>(array.data()[k]);
    }

  public:
    /// How many numbers of a field are used.
    template <class X> std::size_t size_of(const X&) const { return sizeof(X) / sizeof(double); }
    template <class X> std::size_t size_of(const PerRotor<X, 0>&) const {
        return static_cast<std::size_t>(n_) *
               (sizeof(X) / sizeof(std::conditional_t<std::is_same_v<X, int>, int, double>));
    }
    std::size_t size_of(const PerServo<double>&) const { return static_cast<std::size_t>(m_); }

  private:
    int n_, m_;
    Tables& tables_;
};

/// Where the numbers of one field are in a record, and whether they may differ between the flights of a batch.
struct FieldPlace {
    std::string path;
    std::ptrdiff_t at;  // in doubles, from the beginning of the record
    std::size_t width;
    bool varies;
};

/// Every place in the settings of a loop.
inline std::vector<FieldPlace> places_in(const LoopSettings<double, 0>& settings) {
    using Lanes = LoopSettings<Pack<double, 2>, 0>;
    std::vector<FieldPlace> places;
    Tables none;
    const RecordReader reader(settings.plant.vehicle.n_rotors, settings.plant.vehicle.n_servos, none);
    const auto lanes = std::make_unique<Lanes>(convert<Lanes>(settings));
    for_each_leaf("", settings, *lanes, [&](const std::string& path, const auto& x, const auto& y) {
        const std::ptrdiff_t bytes = reinterpret_cast<const char*>(&x) - reinterpret_cast<const char*>(&settings);
        places.push_back(
            {path, bytes / std::ptrdiff_t(sizeof(double)), reader.size_of(x), has_lanes<std::decay_t<decltype(y)>>()});
    });
    return places;
}

}  // namespace omnimorph::python
