#pragma once

/// What the program ends with.
enum ExitCode { kDone = 0, kInternal = 1, kBadUsage = 2, kBadFile = 3, kNoPort = 4, kFailed = 6 };
