() => {
  // faults of visible widgets and figures: one lies over another, leaves the page, or has words that
  // don't fit into it
  const FITS = ".bk-btn, .bk-tab, .bk-slider-title, label";
  const nodes = [], wrong = [], wide = document.documentElement.clientWidth;
  const walk = (root) => { for (const node of root.querySelectorAll("*")) {
    if (node.matches(`${FITS}, .bk-input, .bk-Figure, .noUi-base, h1, th, td`)) nodes.push(node);
    if (node.shadowRoot) walk(node.shadowRoot);
  } };
  walk(document);
  const name = (one) => `${one.className || one.tagName} ${one.textContent.trim().slice(0, 30)}`;
  const rolled = (one) => {  // its visible part in a column that scrolls
    let { left, right, top, bottom } = one.getBoundingClientRect();
    for (let at = one; at; at = at.assignedSlot ?? at.parentNode ?? at.host) {
      if (!(at instanceof Element) || getComputedStyle(at).overflowY !== "auto") continue;
      const hole = at.getBoundingClientRect();
      top = Math.max(top, hole.top); bottom = Math.min(bottom, hole.bottom);
    }
    return { left, right, top, bottom };
  };
  const seen = nodes.filter((one) => one.checkVisibility({ visibilityProperty: true }))
    .map((one) => [one, rolled(one)]).filter(([, r]) => r.right > r.left && r.bottom > r.top);
  for (const [one, box] of seen) {
    if (box.right < -1000) continue;  // read aloud only
    if (box.left < -1 || box.right > wide + 1) wrong.push(`leaves the page: ${name(one)}`);
    if (one.matches(FITS) && one.scrollWidth > one.clientWidth + 1)
      wrong.push(`doesn't fit: ${name(one)}`);
  }
  seen.forEach(([one, p], i) => seen.slice(i + 1).forEach(([other, q]) => {
    if (one.contains(other) || other.contains(one)) return;
    const x = Math.min(p.right, q.right) - Math.max(p.left, q.left);
    const y = Math.min(p.bottom, q.bottom) - Math.max(p.top, q.top);
    if (x > 2 && y > 2) wrong.push(`overlap: ${name(one)} and ${name(other)}`);
  }));
  return seen.length < 12 ? ["too little was found"] : wrong;
}
