// Puts the page together, and draws it anew when the filters change.

const LEGEND = [
  ...DATA.scores.map((score) => [score.label, score.about]),
  ["IT", "Inference time: one forward pass of the planner's network, in milliseconds; point at it for the processor."],
  ["RFDS", "The driving score of the expert that sees only the vehicle the planner ranks first, in percent of the expert that sees all."],
  ["Track", "Sensors: raw signals and the route. Objects: boxes and lights, as from a perfect perception (what PlanT calls privileged). Privileged: what only the simulator knows."],
  ["Told apart", "Two planners are compared on the routes and seeds that both drove. The interval is a bootstrap over routes at 95 %; p is of a test of signs over routes, corrected for all pairs of the table (Holm). A difference is called real where p is 0.05 at most."],
  ["Hazards", "Met: those that took their course. Survived: no collision within 30 m of its place once it had begun."],
];

function boardSection(board) {
  const state = { column: 1, direction: -1 }; // DS, the highest first
  const chosen = {};
  const own = board.details.length > 0;
  const table = el("div");
  const parts = [];

  function openEpisodes(wanted) {
    Object.assign(chosen, { planner: undefined, route: undefined, scenario: undefined, most: AT_ONCE }, wanted);
    const list = parts.at(-1);
    list.part.open = true;
    list.redraw();
    list.part.querySelector("summary").focus({ preventScroll: true });
    list.part.scrollIntoView();
  }

  function drawTable(focused) {
    fill(table, scrolling("Scores", sortedTable({
      caption: `Scores: ${board.title}`, columns: scoreColumns(board, openEpisodes), rows: shownLines(board), state, draw: drawTable,
    })));
    if (known(focused)) table.querySelectorAll("button.sort")[focused].focus();
  }

  const id = (name) => `${board.id}-${name}`;
  const add = (name, title, note, draw) => parts.push(drillDown(id(name), title, note, draw));
  const addInfractions = () => add("infractions", "Infractions", "All counts over all kilometres.", (body) => {
    const lines = shownLines(board);
    const place = el("div", { class: "plot" });
    fill(body, plotKey(lines), place, scrolling("Infractions", infractionTable(lines)));
    plotIn(place, "Infractions per kilometre by kind, a bar a planner; the table below has the numbers", (width) => infractionPlot(lines, width))();
  });
  const forest = own && board.pairs.length ? forestSection(board) : null;
  if (own) {
    if (board.pairs.length) {
      add("matrix", "Who beats whom", "Difference in driving score, row minus column, with its 95 % interval. Coloured where the difference is real; ≈ where it is not shown.", (body) =>
        fill(body, scrolling("Who beats whom", beatMatrix(board, shownLines(board)))));
    }
    add("towns", "Towns", "Driving score by town; the redder, the lower.", (body) => fill(body, scrolling("Towns", townHeat(board, shownLines(board)))));
    add("routes", "Routes", "Mean driving score on each route; the redder, the lower. A cell opens its episodes; arrow keys move between cells.", (body) =>
      fill(body, scrolling("Routes", routeHeat(board, shownLines(board), openEpisodes))));
    add("spread", "Scores of episodes", "The larger a dot, the more of the planner's episodes ended there; the tick is their mean.", (body) => {
      const place = el("div", { class: "plot" });
      fill(body, place);
      plotIn(place, "Driving scores of all episodes, a row a planner", (width) => episodePlot(board, shownLines(board), width))();
    });
    addInfractions();
    add("hazards", "Hazards", "Survived, of those met: no collision near it once it had begun. The redder, the fewer.", (body) => fill(body, scrolling("Hazards", hazardHeat(shownLines(board)))));
    add("endings", "Endings and causes", "How episodes ended, and in how many collisions the ego ran into the other, not the other into it.", (body) => fill(body, scrolling("Endings", endingTable(shownLines(board)))));
    add("comfort", "Near misses and comfort", "Not part of any score. Times are medians of each episode's least; – where the middle episode had no near miss.", (body) => fill(body, scrolling("Comfort", comfortTable(shownLines(board)))));
    if (board.rankings.length) {
      add("rankings", "Rankings (RFDS)", "The expert's driving score with only the first-ranked vehicle in sight.", (body) => fill(body, scrolling("Rankings", rankingTable(board))));
    }
    add("episodes", "Episodes", "What happened in each, with its replay. Pick two of one scenario to watch them side by side.", (body) => fill(body, episodeList(board, chosen, () => parts.at(-1).redraw())));
  }

  if (!own && board.lines.some((line) => Object.keys(line.rates).length)) addInfractions();

  const facts = [own ? counted(board.lines.length, "planner") : null, board.routes.length ? counted(board.routes.length, "route") : null, board.law ? `law ${board.law}` : null, board.source || null];
  const section = el("section", { class: own ? "board" : "board elsewhere", "aria-labelledby": id("title") },
    el("h2", { id: id("title") }, nameOf(board.title, 90)),
    el("p", { class: "muted small facts" }, nameOf(facts.filter(Boolean).join(" · "), 260)),
    own ? verdict(board) : el("p", { class: "notice" }, "These figures are from another world: other towns, other traffic, another simulator. They cannot be compared with ours."),
    table,
    forest?.section,
    parts.length ? el("h3", { class: "more-title" }, "Look closer") : null,
    parts.map((item) => item.part),
  );
  const redraw = () => {
    section.hidden = FILTER.board !== "" && FILTER.board !== board.id;
    if (section.hidden) return;
    drawTable();
    forest?.redraw();
    parts.forEach((item) => item.redraw());
  };
  return { board, section, redraw };
}

function forestSection(board) {
  let reference = board.lines[0];
  const place = el("div", { class: "plot" });
  const draw = plotIn(place, "Differences in driving score with 95 % intervals; the matrix below has the numbers", (width) => forestPlot(board, shownLines(board), reference, width));
  const select = el("select", { onchange: (event) => { reference = board.lines[Number(event.target.value)]; draw(); } },
    board.lines.map((line) => el("option", { value: String(line.place) }, cut(line.planner, 40))));
  const section = el("div", { class: "forest" },
    el("div", { class: "forest-head" }, el("h3", {}, "Is the difference real?"), el("label", { class: "small" }, "against ", select)),
    place,
    el("p", { class: "muted small" }, "Filled: told apart from it. Hollow: could be chance. Bars are 95 % intervals."));
  return { section, redraw: draw };
}

function setUpFilters(sections) {
  const option = ([value, text]) => el("option", { value }, text);
  const place = (name) => document.getElementById(`filter-${name}`);
  const tracks = [...new Set(BOARDS.flatMap((board) => board.lines.map((line) => line.track)))].filter(Boolean);
  place("track").append(...[["", "all"], ...tracks.map((track) => [track, track])].map(option));
  place("town").append(...[["", "all"], ...ownTowns().map((town) => [town, cut(town, 40)])].map(option));
  place("board").append(...[["", "all"], ...BOARDS.map((board) => [board.id, cut(board.title, 60)])].map(option));
  const redraw = () => {
    sections.forEach((item) => item.redraw());
    const boards = BOARDS.filter((board) => !FILTER.board || board.id === FILTER.board);
    const count = (lines) => boards.reduce((total, board) => total + lines(board).length, 0);
    place("count").textContent = `${count(shownLines)} of ${count((board) => board.lines)} planners`;
  };
  for (const name of Object.keys(FILTER)) {
    place(name).addEventListener("input", (event) => {
      FILTER[name] = event.target.value;
      redraw();
    });
  }
  document.getElementById("filters").addEventListener("submit", (event) => event.preventDefault());
  redraw();
}

const sections = BOARDS.map(boardSection);
document.getElementById("boards").append(...sections.map((item) => item.section));
document.getElementById("legend").append(...LEGEND.flatMap(([term, text]) => [el("dt", {}, term), el("dd", {}, text)]));
setUpFilters(sections);
// For who measures: two frames on, all of the above has been painted.
requestAnimationFrame(() => requestAnimationFrame(() => performance.mark("drawn")));
