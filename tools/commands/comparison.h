// The common part of bench and verify: from options to scenes, contenders, documents and output
// files.
#pragma once

#include "commands/commands.h"
#include "files/output_file.h"
#include "report/bench_document.h"
#include "session/contenders.h"
#include "session/session.h"

#include <occlude/core/result.h>

#include <optional>

namespace occlude::tools {

/// The requested output files, all writable.
class ReportFiles {
public:
    /// Opens every file that `options` names, before any long work starts.
    static Result<ReportFiles> open(const CompareOptions& options);

    /// Writes all of them.
    Result<bool> write(std::span<const BenchDocument> documents);

private:
    std::optional<OutputFile> json_;
    std::optional<OutputFile> csv_;
    std::optional<OutputFile> html_;
};

/// A document about `path` on this session; its runs are empty.
BenchDocument describe(Session& session, const CompareOptions& options, const std::string& path,
                       size_t frames);

/// The pairs of objects that have surfaces at exactly the same depth, found from tied pixels of the
/// runs: the ten with most pixels, in descending order.
std::vector<CoincidentObjects> coincident_objects(const Session& session,
                                                  std::span<const AlgorithmRun> runs);

/// Prints what differed, if anything did.
void print_differences(std::span<const AlgorithmRun> runs, std::ostream& out);

/// Reports on `out` what the frames of a document do not prove: frames that show nothing, frames in
/// which nothing is hidden, coincident surfaces. Returns the exit code: kNothingProven if all
/// frames are empty, or, with `must_hide`, if no run hid anything in any frame; with `strict`,
/// kDiffers for coincident surfaces; otherwise kDone.
int judge_evidence(const BenchDocument& document, bool must_hide, bool strict, std::ostream& out);

/// The exit code of a command of which two parts end with these codes.
int worse(int a, int b);

/// The requested algorithms on the requested trees of the session.
Result<std::vector<Contender>> contenders_of(Session& session, const CompareOptions& options,
                                             References references);

/// Checks everything that can be checked before a scene is loaded, so that errors come at once.
/// Reports on `notes` which algorithms are left out on which hierarchies.
Result<bool> check_compare_options(const CompareOptions& options, std::ostream& notes);

} // namespace occlude::tools
