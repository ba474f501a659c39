//! Short lists in order.

/// Sorts a list, the largest key first; of equal ones the earlier stays first. By insertion: lists are short, and the sort of the
/// standard library takes more than a kilobyte of flash for each type of element.
pub(crate) fn descending<T: Copy>(list: &mut [T], key: impl Fn(&T) -> f32) {
    for end in 1..list.len() {
        let Some(&element) = list.get(end) else { return };
        let place = list.iter().take(end).take_while(|other| key(other) >= key(&element)).count();
        if let Some(part) = list.get_mut(place..=end) {
            part.rotate_right(1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::descending;

    #[test]
    fn the_largest_is_first_and_equal_ones_stay_as_they_were() {
        let mut list = [(1.0, 'a'), (3.0, 'b'), (1.0, 'c'), (-2.0, 'd'), (3.0, 'e'), (7.0, 'f')];
        descending(&mut list, |&(key, _)| key);
        assert_eq!(list.map(|(_, name)| name), ['f', 'b', 'e', 'a', 'c', 'd']);
        descending::<f32>(&mut [], |&key| key);
    }
}
