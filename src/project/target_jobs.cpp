#include "furrow/project/target_jobs.h"

#include "furrow/base/file.h"
#include "furrow/image/video.h"

namespace furrow::project {

Result<target::Sheet> sheet_job(const std::filesystem::path& board_file, const std::string& paper,
                                const std::filesystem::path& out, double dpi) {
  FURROW_TRY(const target::BoardSpec board, target::read_board(board_file));
  FURROW_TRY(const target::Paper page, target::find_paper(paper));
  FURROW_TRY(const target::SheetFormat format, target::sheet_format(out));
  FURROW_TRY(target::Sheet sheet, target::draw_sheet(board, page, format, dpi));
  FURROW_DO(base::write_file(out, sheet.bytes));
  return sheet;
}

Result<target::BoardCheck> check_board_job(const std::filesystem::path& board_file,
                                           const std::vector<std::filesystem::path>& named,
                                           const JobOptions& job) {
  FURROW_TRY(const target::BoardSpec board, target::read_board(board_file));
  FURROW_TRY(const auto images, image::picture_files(named));
  return target::check_board(images, board, {}, job.threads, job.progress);
}

}  // namespace furrow::project
