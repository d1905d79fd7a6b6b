// What was found, in words: the one text of stops, of the log, and of refusals in it.
#pragma once

#include "core/chunk/judgement.hpp"

namespace fairlead {

/// `G020 arm linear, row 5: 0.09 m, limit 0.0867 m`, with the key of the limit in brackets where it
/// is known; of a rule `G003 epoch: needs the current arm epoch`. Where a limit comes from may be a
/// page of text: `fairlead why` has it.
Text words_of(const Evidence& evidence);

}  // namespace fairlead
