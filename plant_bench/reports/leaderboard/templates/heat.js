// Tables in which colour points at what is bad: planner x town, planner x route, planner x hazard.

/** A cell whose tint grows with what was lost, 0 to 1. */
function heatCell(lost, content, attributes = {}) {
  const cell = el("td", { class: "heat", ...attributes }, content);
  cell.style.setProperty("--lost", `${Math.round(44 * Math.min(Math.max(lost, 0), 1))}%`);
  return cell;
}

function townHeat(board, lines) {
  const head = el("tr", {}, el("th", { scope: "col" }, "Planner"), board.towns.map((town) => el("th", { scope: "col", class: "number" }, nameOf(town, 20))));
  const rows = lines.map((line) =>
    el("tr", {}, el("th", { scope: "row" }, nameOf(line.planner, 28)), board.towns.map((town) => {
      const score = line.detail.towns[town]?.[RANKED];
      return known(score?.[0]) ? heatCell(1 - score[0] / 100, spreadCell(score, 1), { class: "heat number" }) : el("td", { class: "number" }, "–");
    })),
  );
  return el("table", { class: "towns" }, el("caption", { class: "hidden-text" }, "Driving score by town"), el("thead", {}, head), el("tbody", {}, rows));
}

/** Mean driving score of each planner on each route; a cell opens its episodes. */
function routeHeat(board, lines, openEpisodes) {
  const means = new Map();
  for (const item of board.allEpisodes()) {
    const key = `${item.line.place} ${item.route}`;
    const known = means.get(key) ?? [0, 0];
    means.set(key, [known[0] + item.scores[RANKED], known[1] + 1]);
  }
  const routes = board.routes.map(([name, town]) => ({ name, town: board.towns[town] })).filter((route) => !FILTER.town || route.town === FILTER.town);
  const towns = [...new Set(routes.map((route) => route.town))];
  const townRow = el("tr", {}, el("td", {}), towns.map((town) =>
    el("th", { scope: "colgroup", colspan: routes.filter((route) => route.town === town).length, class: "group" }, nameOf(town, 20))));
  const routeRow = el("tr", {}, el("th", { scope: "col" }, "Planner"), routes.map((route) =>
    el("th", { scope: "col", class: "route", title: cut(route.name, 200) },
      el("span", { "aria-hidden": "true" }, cut(route.name.replace(`${route.town}-`, ""), 6)), el("span", { class: "hidden-text" }, cut(route.name, 80)))));
  const rows = lines.map((line) =>
    el("tr", {}, el("th", { scope: "row" }, nameOf(line.planner, 24)), routes.map((route) => {
      const found = means.get(`${line.place} ${route.name}`);
      if (!found) return el("td", { class: "heat" }, "–");
      const mean = found[0] / found[1];
      const label = `${cut(line.planner)} on ${cut(route.name, 80)}: driving score ${fixed(mean, 0)} in ${found[1]} episodes`;
      return heatCell(1 - mean / 100, el("button", {
        type: "button", "aria-label": label, title: label, onclick: () => openEpisodes({ planner: line, route: route.name }),
      }, fixed(mean, 0)));
    })),
  );
  const caption = el("caption", { class: "hidden-text" }, "Mean driving score by route");
  return roving(el("table", { class: "routes" }, caption, el("thead", {}, townRow, routeRow), el("tbody", {}, rows)));
}

/** Share of the hazards met that passed without a collision, by kind. */
function hazardHeat(lines) {
  const kinds = DATA.hazards.filter((kind) => lines.some((line) => line.detail.hazards[kind]));
  const head = el("tr", {}, el("th", { scope: "col" }, "Planner"), el("th", { scope: "col", class: "number" }, "met"),
    kinds.map((kind) => el("th", { scope: "col", class: "kind" }, words(kind))));
  const rows = lines.map((line) => {
    const all = Object.values(line.detail.hazards);
    const sum = (place) => all.reduce((total, counts) => total + counts[place], 0);
    return el("tr", {}, el("th", { scope: "row" }, nameOf(line.planner, 24)),
      el("td", { class: "number", title: `${sum(3)} were void` }, `${sum(1)} of ${sum(0)}`),
      kinds.map((kind) => {
        const [, met, survived] = line.detail.hazards[kind] ?? [0, 0, 0];
        if (!met) return el("td", { class: "number" }, "–");
        return heatCell(1 - survived / met, [percent(survived / met), el("span", { class: "of" }, `${survived} of ${met}`)], { class: "heat number" });
      }));
  });
  return el("table", { class: "hazards" }, el("caption", { class: "hidden-text" }, "Hazards survived, of those met"), el("thead", {}, head), el("tbody", {}, rows));
}
