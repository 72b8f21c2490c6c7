// What a record is made of, said once: its fields, by name and place. Conversion to other numbers and counts, bindings,
// storage and what may vary from flight to flight follow from the list.
//
//     struct Gains {
//         Vec3<T> position, velocity;
//         static constexpr auto fields() {
//             return std::make_tuple(field("position", &Gains::position), field("velocity", &Gains::velocity));
//         }
//     };
//
// A record is an aggregate, so its members can be counted: one that its list forgets does not compile.
#pragma once

#include <algorithm>
#include <iterator>
#include <string>
#include <tuple>
#include <utility>
#include <variant>

#include "number.hpp"
#include "records.hpp"

namespace omnimorph {

/// A view of numbers owned elsewhere, which outlive it.
struct Table {
    const double* numbers = nullptr;
    long size = 0;
};

/// One field. A derived one follows from others and is set by `derive`, never from outside.
template <class Record, class Member> struct Field {
    const char* name;
    Member Record::* place;
    bool is_derived;
};
template <class Record, class Member> constexpr Field<Record, Member> field(const char* name, Member Record::* place) {
    return {name, place, false};
}
template <class Record, class Member>
constexpr Field<Record, Member> derived(const char* name, Member Record::* place) {
    return {name, place, true};
}

namespace fields {

/// Converts to anything, in an operand that is never evaluated.
struct Anything {
    template <class X> operator X() const;
};
template <class Record, class Places, class = void> struct HasMembers : std::false_type {};
template <class Record, std::size_t... I>
struct HasMembers<Record, std::index_sequence<I...>, std::void_t<decltype(Record{(void(I), Anything{})...})>>
    : std::true_type {};

/// Whether an aggregate has so many members, and not more.
template <class Record, std::size_t Count>
inline constexpr bool has_count = HasMembers<Record, std::make_index_sequence<Count>>::value &&
                                  !HasMembers<Record, std::make_index_sequence<Count + 1>>::value;

template <class X, class = void> struct IsRecord : std::false_type {};
template <class X> struct IsRecord<X, std::void_t<decltype(X::fields())>> : std::true_type {};
template <class X> inline constexpr bool is_record = IsRecord<X>::value;

/// Vec, Mat3, PerRotor …: a structure around one array `a`.
template <class X, class = void> struct IsArray : std::false_type {};
template <class X> struct IsArray<X, std::void_t<decltype(std::declval<X&>().a[0])>> : std::true_type {};
template <class X> inline constexpr bool is_array = IsArray<X>::value || std::is_array_v<X>;
template <class X> constexpr auto& elements_of(X& x) {
    if constexpr (std::is_array_v<X>) {
        return x;
    } else {
        return x.a;
    }
}

/// Records of different kinds, all of them there, or one of them.
template <class X> inline constexpr bool is_list = false;
template <class... Each> inline constexpr bool is_list<Records<Each...>> = true;
template <class X> inline constexpr bool is_choice = false;
template <class... Each> inline constexpr bool is_choice<std::variant<Each...>> = true;

template <class Record> constexpr void expect_every_member() {
    static_assert(has_count<Record, std::tuple_size_v<decltype(Record::fields())>>,
                  "a member is missing in the list of fields");
}

}  // namespace fields

/// visit(field, member) for every field of a record.
template <class Record, class Visit> constexpr void for_each_field(Record& record, Visit&& visit) {
    using Plain = std::remove_const_t<Record>;
    fields::expect_every_member<Plain>();
    std::apply([&](const auto&... each) { (visit(each, record.*each.place), ...); }, Plain::fields());
}

template <class X, class Y, class Visit> void for_each_number(X& x, const Y& y, Visit&& visit);
template <class X, class Y, class Visit> void for_each_leaf(const std::string& path, X& x, const Y& y, Visit&& visit);

namespace fields {

template <class X, class Y, class Visit, std::size_t... I>
void for_each_number_of_records(X& x, const Y& y, Visit&& visit, std::index_sequence<I...>) {
    [[maybe_unused]] constexpr auto of_x = X::fields();
    [[maybe_unused]] constexpr auto of_y = Y::fields();
    (for_each_number(x.*std::get<I>(of_x).place, y.*std::get<I>(of_y).place, visit), ...);
}
template <class Visit> void for_each_number_of_lists(Records<>&, const Records<>&, Visit&&) {}
template <class X, class Y, class Visit> void for_each_number_of_lists(X& x, const Y& y, Visit&& visit) {
    for_each_number(x.first, y.first, visit);
    for_each_number_of_lists(x.rest, y.rest, visit);
}
template <std::size_t I, class X, class Y, class Visit> void for_each_number_of_one(X& x, const Y& y, Visit&& visit) {
    if (y.index() != I) return;
    if (x.index() != I) x.template emplace<I>();
    for_each_number(*std::get_if<I>(&x), *std::get_if<I>(&y), visit);
}
template <class X, class Y, class Visit, std::size_t... I>
void for_each_number_of_choices(X& x, const Y& y, Visit&& visit, std::index_sequence<I...>) {
    (for_each_number_of_one<I>(x, y, visit), ...);
}

}  // namespace fields

namespace fields {

template <class X, class Y, class Visit, std::size_t... I>
void for_each_leaf_of_record(const std::string& path, X& x, const Y& y, Visit&& visit, std::index_sequence<I...>) {
    [[maybe_unused]] const auto one = [&](const auto& of_x, const auto& of_y) {
        using Member = std::decay_t<decltype(x.*of_x.place)>;
        const std::string beside = path.empty() ? "" : path + ".";
        if (!of_x.is_derived)
            for_each_leaf(is_list<Member> ? path : beside + of_x.name, x.*of_x.place, y.*of_y.place, visit);
    };
    (one(std::get<I>(X::fields()), std::get<I>(Y::fields())), ...);
}
template <class Visit> void for_each_leaf_of_list(const std::string&, const Records<>&, const Records<>&, Visit&&) {}
template <class X, class Y, class Visit>
void for_each_leaf_of_list(const std::string& path, X& x, const Y& y, Visit&& visit) {
    const std::string beside = path.empty() ? "" : path + ".";
    for_each_leaf(beside + x.first.name, x.first, y.first, visit);
    for_each_leaf_of_list(path, x.rest, y.rest, visit);
}
template <class X, class Y, class Visit, std::size_t... I>
void for_each_leaf_of_choice(const std::string& path, X& x, const Y& y, Visit&& visit, std::index_sequence<I...>) {
    const auto one = [&](auto k) {
        if (x.index() == k && y.index() == k)
            for_each_leaf(path + "." + std::variant_alternative_t<k, X>::name, *std::get_if<k>(&x), *std::get_if<k>(&y),
                          visit);
    };
    (one(std::integral_constant<std::size_t, I>()), ...);
}

}  // namespace fields

/// visit(path, x, y) for everything in a record that is a number or an array of them, and its like in another: `path`
/// joins the names of the fields by dots. What is derived is left out; a list of records adds no name of its own.
template <class X, class Y, class Visit> void for_each_leaf(const std::string& path, X& x, const Y& y, Visit&& visit) {
    using Plain = std::remove_const_t<X>;
    if constexpr (fields::is_record<Plain>) {
        fields::expect_every_member<Plain>();
        constexpr std::size_t count = std::tuple_size_v<decltype(Plain::fields())>;
        fields::for_each_leaf_of_record(path, x, y, visit, std::make_index_sequence<count>());
    } else if constexpr (fields::is_list<Plain>) {
        fields::for_each_leaf_of_list(path, x, y, visit);
    } else if constexpr (fields::is_choice<Plain>) {
        fields::for_each_leaf_of_choice(path, x, y, visit, std::make_index_sequence<std::variant_size_v<Plain>>());
    } else {
        visit(path, x, y);
    }
}

/// visit(x, y) for every number of one record and its like in another, which may be of other numbers or hold another
/// count of rotors: arrays go together as far as both reach.
template <class X, class Y, class Visit> void for_each_number(X& x, const Y& y, Visit&& visit) {
    if constexpr (fields::is_record<X>) {
        fields::expect_every_member<X>();
        constexpr std::size_t count = std::tuple_size_v<decltype(X::fields())>;
        fields::for_each_number_of_records(x, y, visit, std::make_index_sequence<count>());
    } else if constexpr (fields::is_list<X>) {
        fields::for_each_number_of_lists(x, y, visit);
    } else if constexpr (fields::is_choice<X>) {
        fields::for_each_number_of_choices(x, y, visit, std::make_index_sequence<std::variant_size_v<X>>());
    } else if constexpr (fields::is_array<X>) {
        auto& to = fields::elements_of(x);
        const auto& from = fields::elements_of(y);
        for (std::size_t k = 0; k < std::min(std::size(to), std::size(from)); ++k)
            for_each_number(to[k], from[k], visit);
    } else {
        visit(x, y);
    }
}

/// The same record in other numbers, or for another count of rotors. (Cold: it is done once a flight, and compiles
/// quicker when it need not be quick.)
template <class To, class From> [[gnu::cold, gnu::noinline]] To convert(const From& from) {
    To to{};
    for_each_number(to, from, [](auto& x, const auto& y) { x = static_cast<std::decay_t<decltype(x)>>(y); });
    return to;
}

/// Whether each lane may have its own numbers in it: an array of packs, or a pack.
template <class X> constexpr bool has_lanes() {
    if constexpr (fields::is_array<X>) {
        return has_lanes<
            std::remove_cv_t<std::remove_reference_t<decltype(fields::elements_of(std::declval<X&>())[0])>>>();
    } else {
        return lane_count<X> > 1;
    }
}

/// Put a record into one lane of a record of packs; what has no lanes is the same in all of them.
template <class To, class From> [[gnu::cold, gnu::noinline]] void put_lane(To& to, int index, const From& from) {
    for_each_number(to, from, [index](auto& x, const auto& y) {
        using Number = std::decay_t<decltype(x)>;
        if constexpr (lane_count<Number> > 1) {
            set_lane(x, index, static_cast<Scalar<Number>>(y));
        } else {
            x = static_cast<Number>(y);
        }
    });
}

}  // namespace omnimorph
