#pragma once

#include <string>
#include <string_view>
#include <vector>

// How many guesses a password withstands from somebody who knows common habits. Thread safety: pure
// function, any thread.
//
// The password is cut into pieces, each tried in the order in which people choose them; the rest
// counts 10 a character. The guesses of all pieces are multiplied, and by the number of possible
// orders of that many pieces; of all ways to cut, the cheapest counts. After D. L. Wheeler,
// "zxcvbn: low-budget password strength estimation", USENIX Security 2016, without its term for not
// knowing how many pieces there are: "Summer2026!" is one common shape.
//
// The guesses of each piece:
// * one of CommonPasswords, or of the words in `guesses.cpp`: its rank; twice for capitals, for
//   "p@ssw0rd", for backwards
// * a part of the owner's known data: 1, and the same factors
// * neighbours on a keyboard: 47 keys, its length, 5 for each turn
// * neighbours in the alphabet, digits in a row: 4 from a usual beginning (a, z, 0, 1, 9), else 26
//   or 10; its length; twice backwards
// * a repeated piece: of that piece, times the number of repeats
// * a year, a date: 120 years; 366 days, twice for the order, 4 times for the separator
namespace enamel::server::auth {

// log10 of the guesses. `known`: data about the owner, login and name, each as a whole. A name's
// words, and a login's parts, of three letters and more count by themselves too.
double Log10Guesses(std::string_view password, const std::vector<std::string_view>& known);

}  // namespace enamel::server::auth
