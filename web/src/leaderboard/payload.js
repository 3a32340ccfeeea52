// @ts-check
// Types of the leaderboard's data, as plant_bench/reports/leaderboard/leaderboard_data.py writes it. Numbers
// that are not known are null there.

/**
 * @typedef {[mean: number | null, std: number | null]} Spread
 * @typedef {Record<string, Spread>} Scores by name of metric
 */

/**
 * @typedef {object} Metric
 * @property {string} name
 * @property {string} label
 * @property {string} unit
 * @property {number} digits after the point
 * @property {"higher" | "lower" | ""} better
 * @property {string} about
 * @property {boolean} ofEpisode whether each episode has it, too
 */

/**
 * @typedef {object} Line a planner's row on a board
 * @property {string} id
 * @property {string} planner name as shown
 * @property {string} track
 * @property {string[]} inputs
 * @property {Scores} scores
 * @property {number | null} it inference time, ms
 * @property {number | null} tokens of a forward pass
 * @property {string} processor that the inference time was measured on
 * @property {Spread} rfds percent
 * @property {string} ranker of the RFDS
 * @property {number | null} parameters
 * @property {string} date
 * @property {number} repetitions
 * @property {number} episodes
 * @property {number} expected number of episodes of a complete run
 * @property {boolean} complete whether it has driven all routes of the board
 * @property {string} checksum
 * @property {string} source
 * @property {Record<string, number>} rates infractions per kilometre by kind
 * @property {number | null} km
 */

/**
 * @typedef {object} Details breakdowns of a run of plant-bench
 * @property {Record<string, Scores>} towns
 * @property {Record<string, number>} counts infractions by kind
 * @property {Record<string, number>} statuses episodes by how they ended
 * @property {Record<string, HazardCounts>} hazards by kind
 * @property {[ego: number, other: number]} causes of collisions
 * @property {Record<string, number | null>} measures
 *
 * @typedef {[placed: number, met: number, survived: number, void_: number]} HazardCounts
 */

/**
 * Indices refer to the lists of the same names in the payload.
 * @typedef {[
 *   kind: number, time: number, actor: number, cause: string, share?: number | null
 * ]} PackedInfraction the actor is -1 where there is none
 * @typedef {[kind: number, phase: number, time: number, survived?: number]} PackedHazard
 * @typedef {[
 *   name: string, route: number, repetition: number, scenario: number, status: number,
 *   scores: (number | null)[], duration: number, infractions: PackedInfraction[],
 *   hazards: PackedHazard[], replay: number, reason: string
 * ]} PackedEpisode
 * @typedef {[
 *   better: number, worse: number, mean: number, low: number | null, high: number | null,
 *   p: number | null, corrected: number | null, pairs: number, routes: number,
 *   significant: number
 * ]} PackedDifference
 * @typedef {[
 *   ranker: string, planner: string, mean: number | null, std: number | null, episodes: number
 * ]} Ranking
 */

/**
 * @typedef {object} BoardPayload
 * @property {string} title
 * @property {string} world
 * @property {string} protocol
 * @property {string} suite
 * @property {string} penalties penalty scheme
 * @property {string} source
 * @property {string[]} towns
 * @property {[route: string, town: number][]} routes
 * @property {Line[]} lines
 * @property {PackedDifference[]} differences
 * @property {Ranking[]} rankings
 * @property {Details[]} details of the lines, where they are runs of plant-bench
 * @property {PackedEpisode[][]} episodes of the same lines
 */

/**
 * @typedef {object} LeaderboardPayload
 * @property {Metric[]} scores
 * @property {Metric[]} measures
 * @property {string} ranked name of the score by which tables are sorted
 * @property {string[]} kinds of infractions
 * @property {string[]} hazards kinds of them
 * @property {string[]} statuses
 * @property {string[]} phases of hazards
 * @property {string[]} actors kinds of them
 * @property {BoardPayload[]} boards
 * @property {string[]} notes
 */

export {};
