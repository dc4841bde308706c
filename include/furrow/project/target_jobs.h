#pragma once
#include <filesystem>
#include <string>

#include "furrow/project/jobs.h"
#include "furrow/target/detect.h"
#include "furrow/target/sheet.h"

/// The jobs behind `furrow target`.
namespace furrow::project {

/// Board file -> a page to print in `out`, whose extension (.pdf, .svg, .png) chooses the format. Errors:
/// those of read_board, find_paper, draw_sheet and file writing.
Result<target::Sheet> sheet_job(const std::filesystem::path& board_file, const std::string& paper,
                                const std::filesystem::path& out, double dpi);

/// Board file and pictures (files, folders, patterns) -> whether they fit each other. Errors: those of
/// read_board and picture_files.
Result<target::BoardCheck> check_board_job(const std::filesystem::path& board_file,
                                           const std::vector<std::filesystem::path>& images,
                                           const JobOptions& job = {});

}  // namespace furrow::project
