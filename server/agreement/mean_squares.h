#pragma once

#include "server/agreement/agreement.h"

// Analysis of variance of a table of marks, from which ICC and dependability follow. For this folder.
namespace enamel::server {

// Of work (rows), markers (columns) and the rest, with one mark a cell.
struct MeanSquares {
  double n = 0, k = 0;
  double rows = 0, columns = 0, rest = 0;
  double mean = 0;  // of all marks
};

// Errors: kInvalidInput, as those of agreement.h.
Result<MeanSquares> MeanSquaresOf(const MarkTable& marks);

}  // namespace enamel::server
