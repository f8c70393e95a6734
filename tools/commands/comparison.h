// What bench and verify share: from options to scenes, contenders, documents and output files.
#pragma once

#include "commands/commands.h"
#include "files/output_file.h"
#include "report/bench_document.h"
#include "session/contenders.h"
#include "session/session.h"

#include <occlude/core/result.h>

#include <optional>

namespace occlude::tools {

/// The output files that were asked for, found writable.
class ReportFiles {
public:
    /// Opens every file that `options` names, before anything takes long.
    static Result<ReportFiles> open(const CompareOptions& options);

    /// Writes all of them.
    Result<bool> write(std::span<const BenchDocument> documents);

private:
    std::optional<OutputFile> json_;
    std::optional<OutputFile> csv_;
    std::optional<OutputFile> html_;
};

/// A document about `path` on this session; runs are left empty.
BenchDocument describe(Session& session, const CompareOptions& options, const std::string& path,
                       size_t frames);

/// Which objects have surfaces at exactly the same depth, as tied pixels of the runs show, most
/// pixels first; the ten largest.
std::vector<CoincidentObjects> coincident_objects(const Session& session,
                                                  std::span<const AlgorithmRun> runs);

/// Prints what differed, if anything did.
void print_differences(std::span<const AlgorithmRun> runs, std::ostream& out);

/// What the frames of a document prove, said on `out` where it is less than it seems: frames that
/// show nothing, frames in which nothing is hidden, coincident surfaces. The exit code that
/// follows: kNothingProven if all frames are empty, or, with `must_hide`, if no run hid anything in
/// any; with `strict`, kDiffers for coincident surfaces; else kDone.
int judge_evidence(const BenchDocument& document, bool must_hide, bool strict, std::ostream& out);

/// Of two exit codes the one that a command should end with.
int worse(int a, int b);

/// The algorithms that were asked for on the trees of the session that were.
Result<std::vector<Contender>> contenders_of(Session& session, const CompareOptions& options,
                                             References references);

/// Checks everything that can be checked before a scene is loaded, for messages at once. Says on
/// `notes` which algorithms are left out on which hierarchies.
Result<bool> check_compare_options(const CompareOptions& options, std::ostream& notes);

} // namespace occlude::tools
