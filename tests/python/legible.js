// Checks of a report in the browser. Each returns its complaints.
({
    /** Figures without a line, without a size. */
    missing: () => [...document.querySelectorAll('.plot')].filter((plot) => {
        const drawn = plot.querySelectorAll('.trace, .contour, .contourlines, .contourlayer path, .fills path').length;
        return drawn === 0 || plot.getBoundingClientRect().width < 100 && plot.offsetParent;
    }).map((plot) => plot.getAttribute('aria-label')),

    /** Pictures that are not there, and belts without elements. */
    empty: () => [
        ...[...document.images].filter((one) => one.naturalWidth === 0).map((one) => one.src),
        ...[...document.querySelectorAll('.belt svg')].filter((one) => !one.querySelector('.element[d]')).map(() => 'belt'),
    ],

    /** Legends whose sample has not the colour, width, dash and opacity of a line of its name. */
    legends: () => [...document.querySelectorAll('.keys button')].filter((key) => key.querySelector('path.line')).flatMap((key) => {
        const sample = key.querySelector('path.line'), name = key.childNodes[1].textContent;
        const look = (path, opacity) =>
            [...['stroke', 'strokeWidth', 'strokeDasharray'].map((one) => getComputedStyle(path)[one]), Number(opacity)].join(' ');
        const shown = look(sample, sample.closest('svg').getAttribute('opacity'));
        const drawn = [...key.closest('.chart').querySelectorAll('.plot')].flatMap((plot) =>
            [...plot.querySelectorAll('.scatterlayer .trace')].filter((trace) => trace.__data__[0].trace.name === name)
                .flatMap((trace) => [...trace.querySelectorAll('.js-line')].map((path) => look(path, getComputedStyle(trace).opacity))));
        return drawn.length === 0 || drawn.includes(shown) ? [] : [`${name}: ${shown}, drawn ${drawn[0]}`];
    }),

    /** Labels of axes that are less than 12 px high, are cut off, or overlap. */
    labels: () => [...document.querySelectorAll('.plot')].filter((plot) => plot.offsetParent).flatMap((plot) => {
        const outer = plot.getBoundingClientRect();
        const seen = (selector) => [...plot.querySelectorAll(selector)].map((one) => ({ text: one.textContent, box: one.getBoundingClientRect() }))
            .filter(({ text, box }) => text.trim() && box.width > 0);
        const small = (one) => one.textContent.trim() && parseFloat(getComputedStyle(one).fontSize) < 11.9;
        const complaints = [...plot.querySelectorAll('text')].filter(small).map((one) => `small: ${one.textContent}`);
        for (const { text, box } of [...seen('.xtick text, .ytick text'), ...seen('.xtitle, .ytitle')]) {
            if (box.left < outer.left - 1 || box.right > outer.right + 1 || box.top < outer.top - 1 || box.bottom > outer.bottom + 1) {
                complaints.push(`cut off: ${text}`);
            }
        }
        // The box of a line of text is higher than its digits.
        for (const [selector, from, to, slack] of [['.xtick text', 'left', 'right', 0], ['.ytick text', 'top', 'bottom', 5]]) {
            const ticks = seen(selector).sort((a, b) => a.box[from] - b.box[from]);
            ticks.slice(1).filter((tick, k) => tick.box[from] < ticks[k].box[to] - slack).forEach(({ text }) => complaints.push(`overlap: ${text}`));
        }
        const labels = seen('.annotation-text').sort((a, b) => a.box.left - b.box.left);
        const overlap = (one, other) => one.left < other.right - 1 && one.top < other.bottom - 3 && other.top < one.bottom - 3;
        labels.slice(1).filter(({ box }, k) => overlap(box, labels[k].box)).forEach(({ text }) => complaints.push(`overlap: ${text}`));
        return complaints;
    }),

    /** Cards that are smaller than their content. */
    tight: () => [...document.querySelectorAll('.facts div')]
        .filter((one) => one.scrollHeight > one.clientHeight + 1 || one.scrollWidth > one.clientWidth + 1).map((one) => one.textContent),
})
