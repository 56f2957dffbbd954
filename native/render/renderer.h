// SPDX-License-Identifier: GPL-3.0-or-later
// A render in progress: threads over blocks, what is finished so far, cancel and statistics.
#pragma once

#include <atomic>
#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>

#include "render/block.h"
#include "render/checkpoint.h"
#include "render/error_histogram.h"
#include "render/local_lights.h"

namespace penumbra {

struct RenderStatistics {
  RenderTally tally;
  double seconds = 0;  // from start() to the last block
  double error_mean = 0, error_p99 = 0, error_max = 0;
};

/// Threads take blocks from one atomic counter. Results do not depend on who renders what, or when.
class Renderer {
 public:
  /// Throws std::invalid_argument for settings that are out of range or do not fit together, or for another
  /// render's checkpoint; std::bad_alloc where memory_limit is too small for the film. The scene must not be
  /// changed before the render ends.
  Renderer(std::shared_ptr<const Scene> scene, std::shared_ptr<const Geometry> geometry,
           std::shared_ptr<const Materials> materials, const RenderSettings& settings);
  ~Renderer();

  /// Starts the threads; does nothing the second time.
  void start();
  /// Buckets finished since the last call, relative to the region; waits for the first at most so long.
  std::vector<Rectangle> wait(double seconds);
  /// It was started, and every bucket was reported, or it was cancelled or failed and its threads are idle.
  bool done() const;
  double progress() const;
  /// 99th percentile of the error estimates of all finished buckets' pixels, display units; 0 before the
  /// first.
  double estimated_error() const;
  void cancel() { cancelled_ = true; }
  /// Waits for the threads; rethrows what a worker threw.
  void finish();

  /// Renders the block that holds a pixel (full frame), before start(), and tells of the pixel in lines of
  /// text. Throws std::invalid_argument outside the region or after start().
  std::string debug_pixel(uint32_t x, uint32_t y);

  const Film& film() const { return film_; }
  const RenderSettings& settings() const { return settings_; }
  /// Of a finished render; before finish() of nothing yet.
  const RenderStatistics& statistics() const { return statistics_; }

 private:
  /// The unit in which finished pixels are reported and kept.
  struct Bucket {
    Rectangle area;                 // full frame, clipped to the region
    std::vector<Rectangle> blocks;  // full frame, whole tiles
    size_t blocks_left = 0;         // guarded by mutex_, as is the tally
    RenderTally tally;
    double error_sum = 0;  // of its pixels' estimates; both once it is reported
    float error_max = 0;
  };

  uint32_t thread_count() const;
  uint32_t bucket_side() const;
  uint32_t block_side() const;
  void make_buckets();
  void restore_buckets();
  RenderContext context(BlockMemory& memory);
  std::unique_ptr<LocalLights> local_lights(const RenderContext& context, const Rectangle& block) const;
  void (*block_renderer() const)(const RenderContext&, const Rectangle&, RenderTally&);
  void run_thread(double begin);
  void work();
  void finish_block(Bucket& bucket, const RenderTally& tally);
  void report(Bucket& bucket);
  void summarize();

  std::shared_ptr<const Scene> scene_;
  std::shared_ptr<const Geometry> geometry_;
  std::shared_ptr<const Materials> materials_;
  RenderSettings settings_;
  Film film_;
  ExtraPasses extras_;
  std::unique_ptr<Sampler> light_sampler_, pixel_sampler_;
  PixelFilter filter_;
  CameraRays camera_;
  PathTracer paths_;
  PixelRays pixel_rays_;
  PixelLightSampler pixel_light_sampler_;
  std::unique_ptr<const EdgeMap> edge_map_;
  std::vector<Luminaire> luminaires_;      // those that emit
  std::unique_ptr<LightTree> light_tree_;  // where there are many
  std::unique_ptr<Lighting> lighting_;

  std::unique_ptr<Checkpoint> checkpoint_;
  std::vector<std::unique_ptr<Bucket>> buckets_;
  std::vector<std::pair<uint32_t, uint32_t>> work_;  // bucket, block of it
  size_t block_count_ = 0;                           // those of finished buckets included
  std::atomic<size_t> next_{0}, blocks_done_{0};
  std::atomic<bool> cancelled_{false};

  mutable std::mutex mutex_;
  uint32_t working_ = 0;  // threads; guarded by mutex_, as all below up to the threads
  bool started_ = false;
  std::condition_variable changed_;
  std::vector<Rectangle> finished_;
  ErrorHistogram finished_errors_;
  std::exception_ptr failure_;

  std::vector<std::thread> threads_;
  RenderStatistics statistics_;
};

}  // namespace penumbra
