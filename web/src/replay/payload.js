// @ts-check
// Types of what the scripts beside replay.html hand to the page: plant_bench/reports/replay/replay_site.py
// writes the index, episode.py an episode, towns.py a town.

/**
 * Columns of whole numbers: name, number of values, order of differences, bytes a value.
 * @typedef {[name: string, length: number, order: number, width: number][]} ColumnTable
 */

/**
 * @typedef {object} ReplayIndex
 * @property {boolean} leaderboard whether there is a leaderboard.html beside the page
 * @property {IndexEntry[]} replays
 *
 * @typedef {object} IndexEntry
 * @property {string} id "<run>/<episode>"
 * @property {string} title
 * @property {string} route
 * @property {number} repetition
 * @property {string} scenario
 * @property {string} status
 * @property {number} drivingScore
 * @property {number} infractions
 */

/**
 * @typedef {object} TownPayload
 * @property {number} format
 * @property {string} name
 * @property {string} checksum
 * @property {string[]} kinds of pieces
 * @property {ColumnTable} columns
 * @property {string} data the columns, deflated, in base64
 */

/**
 * Why an episode has no replay.
 * @typedef {{id: string, error: string}} ReplayError
 */

/**
 * @typedef {object} EpisodePayload
 * @property {undefined} [error]
 * @property {number} format
 * @property {string} id "<run>/<episode>"
 * @property {string} title
 * @property {string} protocol
 * @property {string} route
 * @property {string} town
 * @property {string} townChecksum
 * @property {string} scenario
 * @property {number} repetition
 * @property {number} seed
 * @property {string} density
 * @property {number} step s between frames
 * @property {number} tick s between ticks
 * @property {[length: number, width: number]} egoExtent m
 * @property {{length: number, angle: number, share: number}} scales units per metre, radian and 1
 * @property {string[]} kinds of actors
 * @property {string[]} lightNames
 * @property {string[]} causes
 * @property {EpisodeResult} result
 * @property {InfractionFacts[]} infractions
 * @property {HazardFacts[]} hazards
 * @property {[along: number, limit: number][]} limits speed limits, m/s, from metres along the route
 * @property {StopLine[]} signals
 * @property {string} attentionNote why no attention is shown
 * @property {string} expertNote why the expert is not always shown
 * @property {boolean} expertDrove
 * @property {ColumnTable} columns
 * @property {string} data the columns, deflated, in base64
 */

/**
 * @typedef {[x: number, y: number, heading: number, halfWidth: number]} StopLine
 *
 * @typedef {object} EpisodeResult
 * @property {string} status
 * @property {string} reason
 * @property {number} completion
 * @property {number} infractionScore
 * @property {number} drivingScore
 * @property {number} duration s
 * @property {number} length m
 *
 * @typedef {object} InfractionFacts
 * @property {string} kind
 * @property {number} time s
 * @property {number} x
 * @property {number} y
 * @property {number} progress m
 * @property {number | null} actor
 * @property {string | null} actorKind
 * @property {string | null} cause
 * @property {number | null} share of the way
 * @property {number} factor of the score
 * @property {number} speed of the ego, m/s
 *
 * @typedef {object} HazardFacts
 * @property {string} kind
 * @property {string} letter
 * @property {string} sentence
 * @property {number} time s
 * @property {[x: number, y: number, heading: number]} place
 * @property {string} phase
 * @property {string} reason
 */

export {};
